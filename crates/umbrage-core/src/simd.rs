//! Run-time choice of vector instructions, without a second copy of any loop.

/// Which instructions a loop is compiled for. Both give the same bits: nothing is reordered, and fused multiplications
/// are fused in both (by hardware in one, in software in the other).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Simd {
    /// The best that this processor has and `pulp` knows.
    #[default]
    Native,
    /// What the compiler may assume of every processor of this kind.
    Baseline,
}

impl Simd {
    /// Runs `f`, compiled for the chosen instructions as far as it is inlined: mark what it calls `#[inline(always)]`.
    #[inline]
    pub fn run<R>(self, f: impl FnOnce() -> R) -> R {
        match self {
            Self::Native => pulp::Arch::new().dispatch(f),
            Self::Baseline => f(),
        }
    }
}
