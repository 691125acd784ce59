// What one thread hands to another that needs only the newest.
#ifndef SELFPROJ_HOST_PRODUCTION_NEWEST_H
#define SELFPROJ_HOST_PRODUCTION_NEWEST_H

#include <atomic>
#include <memory>

namespace selfproj::production {

// One thread puts and another takes. Neither ever waits for the other, which a mutex cannot promise: its owner may have
// the lower priority, and may be stopped by the system while it has it.
template <typename T>
class Newest {
 public:
  Newest() = default;
  Newest(const Newest&) = delete;
  Newest& operator=(const Newest&) = delete;
  ~Newest() { take(); }

  // What was put before and not taken is deleted.
  void put(std::unique_ptr<T> value) {
    const std::unique_ptr<T> before(place_.exchange(value.release(), std::memory_order_acq_rel));
  }

  // What was put since the last call, or null.
  std::unique_ptr<T> take() { return std::unique_ptr<T>(place_.exchange(nullptr, std::memory_order_acq_rel)); }

 private:
  std::atomic<T*> place_{nullptr};
};

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_NEWEST_H
