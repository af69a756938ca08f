#include "kernels/base/parallel_for.h"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <new>
#include <thread>

#include "kernels/base/processors.h"

namespace egosieve::kernels {
namespace {

// Work that justifies a further thread: some tenths of a millisecond.
constexpr double kFlopsPerThread = 5e6;

int ThreadsAtFirst() {
  const char* environment = std::getenv("EGOSIEVE_THREADS");
  const int threads = environment != nullptr ? std::atoi(environment) : 0;
  return threads > 0 ? std::min(threads, kMostThreads) : AvailableProcessors();
}

std::atomic<int> maximum_threads{0};

// NaN is treated as little work.
int64_t WorthwhileThreads(double flops) {
  const double threads = 1.0 + flops / kFlopsPerThread;
  constexpr int64_t kMany = 1 << 20;
  return threads >= kMany ? kMany : threads >= 1.0 ? static_cast<int64_t>(threads) : 1;
}

// The tasks of one call; it lives on the caller's stack.
class Call {
 public:
  Call(int64_t count, absl::FunctionRef<void(int64_t)> task) : count_(count), task_(task) {}

  // Takes tasks until none is left.
  void Run() {
    for (int64_t i = next_++; i < count_; i = next_++) {
      try {
        task_(i);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (!thrown_) thrown_ = std::current_exception();
        next_ = count_;
      }
    }
  }

  // Call it after all Runs have ended.
  void RethrowWhatWasThrown() {
    if (thrown_) std::rethrow_exception(thrown_);
  }

  // Used by Workers, under its lock.
  int64_t wanted = 0;             // workers still to come
  int64_t running = 0;            // workers in Run
  Call* following = nullptr;      // next in the list of calls
  std::condition_variable ended;  // signalled when running may be 0

 private:
  const int64_t count_;
  const absl::FunctionRef<void(int64_t)> task_;
  std::atomic<int64_t> next_{0};
  std::mutex mutex_;
  std::exception_ptr thrown_;  // guarded by mutex_
};

// The threads besides the callers'. They are started if there is no idle one, then kept. The object
// owns no allocated memory, so that Forget leaks nothing.
class Workers {
 public:
  // The process's only instance. It is never destroyed, since its threads wait on it until the
  // process ends.
  static Workers& Instance() {
    static Workers* const workers = [] {
      pthread_atfork(nullptr, nullptr, Forget);
      return new (storage) Workers;
    }();
    return *workers;
  }

  // Runs the call on the caller's thread and up to `helpers` workers; returns when all have ended.
  void Share(Call& call, int64_t helpers) {
    Offer(call, helpers);
    call.Run();
    std::unique_lock<std::mutex> lock(mutex_);
    Withdraw(call);
    call.ended.wait(lock, [&call] { return call.running == 0; });
  }

 private:
  // For a forked child, which has none of the threads but perhaps a lock that one of them held.
  static void Forget() { new (storage) Workers; }

  void Offer(Call& call, int64_t helpers) {
    const std::lock_guard<std::mutex> lock(mutex_);
    call.wanted = helpers;
    call.following = calls_;
    calls_ = &call;
    wanted_ += helpers;
    try {
      for (; idle_ < wanted_; ++idle_) std::thread(&Workers::Work, this).detach();
    } catch (const std::exception&) {
      // There is no further thread, or no memory for one: the existing threads do all the work.
    }
    called_.notify_all();
  }

  // The lock must be held.
  void Withdraw(Call& call) {
    if (call.wanted == 0) return;
    wanted_ -= call.wanted;
    call.wanted = 0;
    Unlink(call);
  }

  void Unlink(const Call& call) {
    Call** link = &calls_;
    while (*link != &call) link = &(*link)->following;
    *link = call.following;
  }

  void Work() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      called_.wait(lock, [this] { return calls_ != nullptr; });
      Call& call = *calls_;
      --idle_;
      --wanted_;
      ++call.running;
      if (--call.wanted == 0) Unlink(call);
      lock.unlock();
      call.Run();
      lock.lock();
      ++idle_;
      if (--call.running == 0) call.ended.notify_one();
    }
  }

  alignas(std::max_align_t) static unsigned char storage[];

  std::mutex mutex_;
  std::condition_variable called_;
  Call* calls_ = nullptr;  // calls that need workers, the latest first
  int64_t wanted_ = 0;     // in all calls together
  int64_t idle_ = 0;       // threads that wait for a call, or are about to wait
};

alignas(std::max_align_t) unsigned char Workers::storage[sizeof(Workers)];

}  // namespace

void SetMaximumThreads(int threads) { maximum_threads = std::max(threads, 0); }

int MaximumThreads() {
  static const int at_first = ThreadsAtFirst();
  const int threads = maximum_threads;
  return threads > 0 ? threads : at_first;
}

void ParallelFor(int64_t count, const ParallelLimits& limits,
                 absl::FunctionRef<void(int64_t)> task) {
  const int most = limits.threads > 0 ? limits.threads : MaximumThreads();
  const int64_t threads = std::min<int64_t>({most, count, WorthwhileThreads(limits.flops)});
  Call call(count, task);
  if (threads > 1) {
    Workers::Instance().Share(call, threads - 1);
  } else {
    call.Run();
  }
  call.RethrowWhatWasThrown();
}

void ParallelFor(int64_t count, double flops, absl::FunctionRef<void(int64_t)> task) {
  ParallelFor(count, ParallelLimits{.flops = flops}, task);
}

void ParallelFor(int64_t count, absl::FunctionRef<void(int64_t)> task) {
  ParallelFor(count, ParallelLimits{}, task);
}

}  // namespace egosieve::kernels
