#include "server/record/broadcast.h"

#include <algorithm>
#include <utility>

namespace mwidth::record {
namespace {

// Phases in the order 0, 1/2, 1/4, 3/4, 1/8, ...: however many are taken, they are spread evenly.
constexpr std::size_t kPhases = 16;

std::size_t PhaseOf(std::size_t number, std::size_t min_batch) {
  std::size_t sixteenths = 0;
  for (std::size_t bit = 1; bit < kPhases; bit *= 2) {
    sixteenths = 2 * sixteenths + ((number & bit) != 0 ? 1 : 0);
  }
  return sixteenths * min_batch / kPhases;
}

// The batch without its first samples, as the first of a stream that begins there.
Batch Later(const Batch& batch, std::size_t first) {
  Batch later;
  later.first_tick = batch.first_tick + first * batch.decimation;
  later.decimation = batch.decimation;
  later.reduction = batch.reduction;
  const auto skip = static_cast<std::ptrdiff_t>(first);
  later.samples.assign(batch.samples.begin() + skip, batch.samples.end());
  if (!batch.extremes.empty()) {
    later.extremes.assign(batch.extremes.begin() + skip, batch.extremes.end());
  }
  return later;
}

}  // namespace

/// Subscribers who share every batch.
class Broadcast::Group {
 public:
  using Members = std::vector<std::shared_ptr<SubscriberQueue>>;

  Group(const Cut& of, std::size_t number_of_cut)
      : cut(of), number(number_of_cut), batcher(of, PhaseOf(number_of_cut, of.min_batch)) {}

  bool full() const { return cut.min_batch > 1 && members.size() >= kGroupSize; }

  // `current`: the members, without the broadcast's lock.
  static void Publish(const Batch& batch, const Encode& encode, const Members& current) {
    const auto shared = MakeEncoded(batch, encode);
    std::shared_ptr<const EncodedBatch> later;
    for (const auto& member : current) {
      if (member->begun()) {
        member->Offer(shared);
        continue;
      }
      const std::size_t first = member->FirstSampleOf(batch);
      if (first >= batch.samples.size()) {
        continue;
      }
      // Those who join at once mostly begin at the same tick.
      const uint64_t first_tick = batch.first_tick + first * batch.decimation;
      if (later == nullptr || later->first_tick != first_tick) {
        later = MakeEncoded(Later(batch, first), encode);
      }
      member->Offer(later);
    }
  }

  const Cut cut;
  // Decides the phase; of the groups of one cut no two have the same.
  const std::size_t number;
  // Whoever consumes.
  Batcher batcher;
  // Under the broadcast's lock.
  Members members;
};

Broadcast::Broadcast(Encode encode, BroadcastLimits limits) : encode_(std::move(encode)), limits_(limits) {}

Broadcast::~Broadcast() = default;

std::unique_ptr<Subscription> Broadcast::Subscribe(const Cut& cut, uint64_t first_tick,
                                                   std::function<void()> notify) {
  const std::lock_guard one_at_a_time(subscribe_mutex_);
  if (subscribers() >= limits_.max_subscribers) {
    return nullptr;
  }
  std::shared_ptr<Group> group = FindGroup(cut);
  const bool made = group == nullptr;
  if (made) {
    group = std::make_shared<Group>(cut, FreePhase(cut));
  }
  const std::lock_guard lock(mutex_);
  // Its last member may have left meanwhile, and taken it out.
  if (made || std::find(groups_.begin(), groups_.end(), group) == groups_.end()) {
    groups_.push_back(group);
  }
  auto queue = std::make_shared<SubscriberQueue>(
      SubscriberQueue::Terms{
          .first_tick = first_tick, .max_batch = cut.max_batch, .max_samples = limits_.max_queued_samples},
      std::move(notify), closed_);
  group->members.push_back(queue);
  ++subscribers_;
  return std::unique_ptr<Subscription>(new Subscription(*this, std::move(queue)));
}

void Broadcast::Consume(std::shared_ptr<const SampleBlock> block) {
  for (const auto& group : AllGroups()) {
    // A copy: a notification may subscribe and unsubscribe.
    Group::Members members;
    group->batcher.Take(*block, [&](const Batch& batch) {
      if (members.empty()) {
        const std::lock_guard lock(mutex_);
        members = group->members;
      }
      Group::Publish(batch, encode_, members);
    });
    for (const auto& member : members) {
      member->Notify();
    }
  }
}

bool Broadcast::eager() const {
  const std::lock_guard lock(mutex_);
  return std::any_of(groups_.begin(), groups_.end(), [](const auto& group) {
    return group->cut.min_batch * group->cut.decimation < kPatientTicks;
  });
}

void Broadcast::Close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  for (const auto& group : AllGroups()) {
    Group::Members members;
    {
      const std::lock_guard lock(mutex_);
      members = group->members;
    }
    group->batcher.Flush([&](const Batch& batch) { Group::Publish(batch, encode_, members); });
    for (const auto& member : members) {
      member->Close();
    }
  }
}

std::size_t Broadcast::subscribers() const {
  const std::lock_guard lock(mutex_);
  return subscribers_;
}

std::size_t Broadcast::groups() const {
  const std::lock_guard lock(mutex_);
  return groups_.size();
}

std::shared_ptr<Broadcast::Group> Broadcast::FindGroup(const Cut& cut) const {
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(groups_.begin(), groups_.end(),
                                  [&](const auto& group) { return group->cut == cut && !group->full(); });
  return found == groups_.end() ? nullptr : *found;
}

std::size_t Broadcast::FreePhase(const Cut& cut) const {
  const std::lock_guard lock(mutex_);
  std::size_t number = 0;
  const auto taken = [&](const auto& group) { return group->cut == cut && group->number == number; };
  while (std::any_of(groups_.begin(), groups_.end(), taken)) {
    ++number;
  }
  return number;
}

Broadcast::Groups Broadcast::AllGroups() const {
  const std::lock_guard lock(mutex_);
  return groups_;
}

void Broadcast::Remove(const SubscriberQueue* queue) {
  const std::lock_guard lock(mutex_);
  const auto is_queue = [queue](const auto& candidate) { return candidate.get() == queue; };
  for (const auto& group : groups_) {
    subscribers_ -= std::erase_if(group->members, is_queue);
  }
  std::erase_if(groups_, [](const auto& group) { return group->members.empty(); });
}

Subscription::Subscription(Broadcast& broadcast, std::shared_ptr<SubscriberQueue> queue)
    : broadcast_(broadcast), queue_(std::move(queue)) {}

Subscription::~Subscription() {
  broadcast_.Remove(queue_.get());
  queue_->Detach();
}

}  // namespace mwidth::record
