//! Progress of the planner.

/// Step of the planner, reported from any thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step<'a> {
    /// It finds where visibility varies.
    Looking,
    /// It traces truth: work done, total work.
    Truth(usize, usize),
    /// It evaluates this technique; the number counts the settings evaluated before.
    Trying(&'a str, usize),
    /// It runs and times this many finalists in turn.
    Timing(usize),
    /// It writes the reasons.
    Explaining,
}

/// Callback that receives the planner's current step.
pub type OnStep<'a> = dyn Fn(Step<'_>) + Sync + 'a;
