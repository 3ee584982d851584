//! Progress of the planner.

/// Receives the planner's progress, from any thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step<'a> {
    /// It looks for where visibility varies.
    Looking,
    /// It traces truth: work done, work in all.
    Truth(usize, usize),
    /// It tries this technique; so many settings were tried before.
    Trying(&'a str, usize),
    /// It plays so many finalists in turn and times them.
    Timing(usize),
    /// It writes down the reasons.
    Explaining,
}

/// Called with what the planner is at.
pub type OnStep<'a> = dyn Fn(Step<'_>) + Sync + 'a;
