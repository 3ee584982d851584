//! Run-time choice of vector instructions, without a second copy of any loop.

/// Which instructions a loop is compiled for. Both give the same bits: nothing is reordered, and
/// fused multiplications are fused in both (by hardware in one, in software in the other).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Simd {
    /// The best that this processor has and `pulp` knows; without the feature `simd`, the same as
    /// [`Baseline`](Self::Baseline).
    #[default]
    Native,
    /// What the compiler may assume of every processor of this kind.
    Baseline,
}

impl Simd {
    /// Does the work, compiled for the chosen instructions as far as it is inlined: mark what it
    /// calls `#[inline(always)]`.
    #[inline]
    pub fn run_task<T: SimdTask>(self, task: T) -> T::Output {
        #[cfg(feature = "simd")]
        {
            let instructions = match self {
                Self::Native => pulp::Arch::new(),
                Self::Baseline => pulp::Arch::Scalar,
            };
            // One dispatch for both, as each inlines the task once for every set of instructions,
            // and long tasks take seconds to compile.
            instructions.dispatch(Inlined(task))
        }
        #[cfg(not(feature = "simd"))]
        task.run()
    }
}

/// Work that is compiled once for each set of instructions. A closure's body is inlined only as the
/// compiler likes, and a long one isn't; a method can insist: mark `run` `#[inline(always)]`.
pub trait SimdTask {
    /// What comes of it.
    type Output;
    /// Does the work.
    fn run(self) -> Self::Output;
}

#[cfg(feature = "simd")]
struct Inlined<T>(T);

#[cfg(feature = "simd")]
impl<T: SimdTask> pulp::WithSimd for Inlined<T> {
    type Output = T::Output;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> T::Output {
        self.0.run()
    }
}
