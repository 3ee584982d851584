//! The common input error: what is wrong, why, and what to do.

/// Error for input that cannot be used. Displays as `what: why; help`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}: {why}; {help}")]
pub struct Invalid {
    /// The invalid thing, named as in the user's input: ``mesh `floor` ``.
    pub what: String,
    /// The reason, with the offending value.
    pub why: String,
    /// Advice, in the imperative.
    pub help: String,
}

impl Invalid {
    /// Builds the error from its three parts.
    pub fn new(what: impl Into<String>, why: impl Into<String>, help: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            why: why.into(),
            help: help.into(),
        }
    }

    /// Returns the error with its container prepended: `what` becomes `outer, what`.
    #[must_use]
    pub fn within_context(mut self, outer: impl std::fmt::Display) -> Self {
        self.what = format!("{outer}, {}", self.what);
        self
    }
}

/// Checks that every number is finite.
pub fn finite(what: &str, values: &[f32]) -> Result<(), Invalid> {
    match values.iter().find(|v| !v.is_finite()) {
        None => Ok(()),
        Some(v) => Err(Invalid::new(
            what,
            format!("holds {v}"),
            "use finite numbers",
        )),
    }
}

/// Checks that `value` is finite and greater than zero.
pub fn positive(what: &str, value: f32) -> Result<(), Invalid> {
    finite(what, &[value])?;
    if value > 0.0 {
        return Ok(());
    }
    Err(Invalid::new(
        what,
        format!("is {value}"),
        "use a number greater than zero",
    ))
}

/// Checks that `value` is finite and at least zero.
pub fn not_negative(what: &str, value: f32) -> Result<(), Invalid> {
    finite(what, &[value])?;
    if value >= 0.0 {
        return Ok(());
    }
    Err(Invalid::new(
        what,
        format!("is {value}"),
        "use zero or more",
    ))
}

/// Checks that `v` is finite and not the zero vector.
pub fn direction(what: &str, v: glam::Vec3) -> Result<(), Invalid> {
    finite(what, &v.to_array())?;
    if v.as_dvec3().length_squared() > 0.0 {
        return Ok(());
    }
    Err(Invalid::new(
        what,
        "is the zero vector",
        "use a direction of any length greater than zero",
    ))
}
