//! The best instruction set of the machine, chosen at run time.

use pulp::{Simd, WithSimd};

/// A computation that is compiled once for each instruction set.
///
/// `run`, and what it calls in its hot loops, must be `#[inline(always)]`: only what is inlined is compiled anew. (That is
/// why this is no closure: the body of a closure stays a function of its own, for the least instruction set.)
pub(crate) trait Kernel {
    /// What it computes.
    type Output;
    /// Computes it.
    fn run(self) -> Self::Output;
}

/// Runs a kernel in its version for this machine.
pub(crate) fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    pulp::Arch::new().dispatch(Compiled(kernel))
}

struct Compiled<K>(K);

impl<K: Kernel> WithSimd for Compiled<K> {
    type Output = K::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> K::Output {
        self.0.run()
    }
}
