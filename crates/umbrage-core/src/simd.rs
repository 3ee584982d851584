//! Run-time choice of vector instructions, with one copy of each loop in the source.

/// Instruction set that a loop is compiled for. Both variants return the same bits: nothing is
/// reordered, and fused multiplications are fused in both (in hardware or in software).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Simd {
    /// The best instruction set of this processor that `pulp` supports. Without the feature `simd`,
    /// the same as [`Baseline`](Self::Baseline).
    #[default]
    Native,
    /// The instructions that every processor of the target has.
    Baseline,
}

impl Simd {
    /// Runs the task, compiled for the chosen instructions. Only inlined code is: mark the
    /// functions that it calls `#[inline(always)]`.
    #[inline]
    pub fn run_task<T: SimdTask>(self, task: T) -> T::Output {
        #[cfg(feature = "simd")]
        {
            let instructions = match self {
                Self::Native => pulp::Arch::new(),
                Self::Baseline => pulp::Arch::Scalar,
            };
            // Dispatch both variants in one place: each dispatch inlines the task once per
            // instruction set, and long tasks take seconds to compile.
            instructions.dispatch(Inlined(task))
        }
        #[cfg(not(feature = "simd"))]
        task.run()
    }
}

/// Work that is compiled once for each instruction set. It is a trait rather than a closure because
/// the compiler does not inline long closures. Mark `run` `#[inline(always)]`.
pub trait SimdTask {
    /// Result of the work.
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
