// Protects the commands: what a chunk throws on another thread is an error like any other, not the end of the process.
#include "inhabit/nn/parallel_chunks.h"

#include <gtest/gtest.h>

#include <atomic>

#include "inhabit/error.h"

namespace inhabit::nn {
namespace {

TEST(ParallelChunks, ThrowsWhatAChunkThrew) {
  const int before = at::get_num_threads();
  for (const int threads : {1, 3}) {
    at::set_num_threads(threads);
    std::atomic<int> done = 0;
    const auto work = [&](int64_t chunk) {
      if (chunk == 5) throw Error("chunk", "is the fifth");
      ++done;
    };
    EXPECT_THROW(parallel_chunks(16, work), Error) << threads;
    EXPECT_LE(done, threads == 1 ? 5 : 15);  // what had not begun is left out
    EXPECT_GE(done, threads == 1 ? 5 : 1);
  }
  at::set_num_threads(before);
}

TEST(ParallelChunks, EndsOnAllThreadsWhereItsCallerIsInterrupted) {
  const int before = at::get_num_threads();
  at::set_num_threads(2);
  struct Stop {};
  const Interruptible here([] { throw Stop(); });
  const auto work = [&](int64_t) {
    for (;;) interruption_point();
  };
  EXPECT_THROW(parallel_chunks(2, work), Stop);
  at::set_num_threads(before);
}

}  // namespace
}  // namespace inhabit::nn
