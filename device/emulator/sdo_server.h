// The SDO server of an emulated CANopen node (CiA 301, section 7.2.4): expedited transfers.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "device/emulator/object_dictionary.h"

namespace mwidth::device::emulator {

/// The 8 bytes that answer the bytes of a request; none where there is nothing to answer. `broken`: refuses
/// whatever is asked.
std::optional<std::vector<uint8_t>> AnswerSdo(std::span<const uint8_t> request, ObjectDictionary& objects,
                                              bool broken);

}  // namespace mwidth::device::emulator
