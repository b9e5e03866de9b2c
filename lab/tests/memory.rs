//! The counting allocator, alone in its process: no other test allocates beside it.

use lab::memory::live_bytes;

#[test]
fn the_allocator_counts_what_is_live() {
    let before = live_bytes();
    let mut bytes = Vec::<u8>::with_capacity(1000);
    assert_eq!(live_bytes() - before, 1000);
    bytes.reserve_exact(5000);
    assert_eq!(live_bytes() - before, 5000);
    bytes.shrink_to(100);
    assert_eq!(live_bytes() - before, 100);
    drop(bytes);
    assert_eq!(live_bytes() - before, 0);
}
