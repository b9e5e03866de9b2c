//! How much memory is in use.

use std::alloc::System;

use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};

/// Counts what goes through it.
#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Bytes that this process has asked for and not given back, all threads together. Differences of it mean something.
pub fn live_bytes() -> isize {
    let stats = ALLOCATOR.stats();
    // A growing reallocation counts as an allocation of the difference, a shrinking one as the opposite.
    stats.bytes_allocated as isize - stats.bytes_deallocated as isize
}
