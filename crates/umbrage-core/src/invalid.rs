//! The one shape of an input error: what is wrong, why, and how to help.

/// An input that cannot be used. Displays as `what: why; help`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}: {why}; {help}")]
pub struct Invalid {
    /// The thing that is wrong, named as its maker would: ``mesh `floor` ``.
    pub what: String,
    /// Why it cannot be used, with the offending value.
    pub why: String,
    /// What to do about it, in the imperative.
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

    /// The same error, seen from a container: `what` becomes `outer, what`.
    #[must_use]
    pub fn within(mut self, outer: impl std::fmt::Display) -> Self {
        self.what = format!("{outer}, {}", self.what);
        self
    }
}

/// Objects unless every number is finite.
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

/// Objects unless `value` is finite and greater than zero.
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

/// Objects unless `value` is finite and at least zero.
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

/// Objects unless `v` is finite and longer than zero.
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
