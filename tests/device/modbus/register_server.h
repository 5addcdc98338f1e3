// A drive in the form of a script: holding registers that a test looks into and sets.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <utility>

#include "tests/device/modbus/scripted_peer.h"

namespace mwidth::device::modbus::testing {

/// Answers functions 3, 16 and 23 of Modbus TCP for unit 1; registers that were never set answer exception 2.
/// Any thread.
class Registers {
 public:
  void Set(uint16_t address, uint16_t value) {
    const std::lock_guard lock(mutex_);
    registers_[address] = value;
  }
  uint16_t Get(uint16_t address) const {
    const std::lock_guard lock(mutex_);
    return registers_.at(address);
  }
  /// From now on no request is answered.
  void FallSilent(bool silent) {
    const std::lock_guard lock(mutex_);
    silent_ = silent;
  }
  /// From now on a write that begins at one of these answers exception 4 and changes nothing.
  void RefuseWrites(std::set<uint16_t> addresses) {
    const std::lock_guard lock(mutex_);
    refused_ = std::move(addresses);
  }
  /// How often any request came.
  int requests() const {
    const std::lock_guard lock(mutex_);
    return requests_;
  }

  Pieces Answer(const Bytes& request) {
    const std::lock_guard lock(mutex_);
    ++requests_;
    if (silent_) {
      return {};
    }
    Bytes pdu;
    switch (request[7]) {
      case 3:
        pdu = Read(request, Word(request, 8), Word(request, 10));
        break;
      case 16:
        if (refused_.contains(Word(request, 8))) {
          pdu = {16 | 0x80, 4};
          break;
        }
        Write(Word(request, 8), Word(request, 10), request, 13);
        pdu.assign(request.begin() + 7, request.begin() + 12);
        break;
      default:
        Write(Word(request, 12), Word(request, 14), request, 17);
        pdu = Read(request, Word(request, 8), Word(request, 10));
    }
    Bytes frame{request[0], request[1], 0, 0, 0, static_cast<uint8_t>(pdu.size() + 1), request[6]};
    frame.insert(frame.end(), pdu.begin(), pdu.end());
    return {frame};
  }

 private:
  static uint16_t Word(const Bytes& bytes, std::size_t at) {
    return static_cast<uint16_t>(bytes[at] << 8 | bytes[at + 1]);
  }
  Bytes Read(const Bytes& request, uint16_t address, uint16_t count) const {
    Bytes pdu{request[7], static_cast<uint8_t>(2 * count)};
    for (uint16_t i = 0; i < count; ++i) {
      const auto found = registers_.find(static_cast<uint16_t>(address + i));
      if (found == registers_.end()) {
        return {static_cast<uint8_t>(request[7] | 0x80), 2};
      }
      pdu.push_back(static_cast<uint8_t>(found->second >> 8));
      pdu.push_back(static_cast<uint8_t>(found->second));
    }
    return pdu;
  }
  void Write(uint16_t address, uint16_t count, const Bytes& request, std::size_t at) {
    for (uint16_t i = 0; i < count; ++i) {
      registers_[static_cast<uint16_t>(address + i)] = Word(request, at + 2 * std::size_t{i});
    }
  }

  mutable std::mutex mutex_;
  std::map<uint16_t, uint16_t> registers_;
  std::set<uint16_t> refused_;
  bool silent_ = false;
  int requests_ = 0;
};

}  // namespace mwidth::device::modbus::testing
