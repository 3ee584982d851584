//! Bounds of a plan: error, time and memory.

use serde::{Deserialize, Serialize};
use umbrage_core::Invalid;

/// The greatest error, time and memory that shadows may have. Bounds that are not given bound nothing; at least one must be given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Bounds {
    /// Greatest root mean square of mask - truth over the pixels that count, 0..=1.
    pub max_error: Option<f64>,
    /// Greatest predicted time of casts, filters and lookup, milliseconds.
    pub max_ms: Option<f64>,
    /// Most bytes of images and tables.
    pub max_bytes: Option<u64>,
}

impl Bounds {
    /// Returns a bound of the error; the cheapest technique within it is planned.
    pub fn error(max_error: f64) -> Self {
        Self {
            max_error: Some(max_error),
            ..Self::default()
        }
    }

    /// Returns a bound of the time; the most accurate technique within it is planned.
    pub fn milliseconds(max_ms: f64) -> Self {
        Self {
            max_ms: Some(max_ms),
            ..Self::default()
        }
    }

    /// Returns a bound of the memory; the most accurate technique within it is planned.
    pub fn bytes(max_bytes: u64) -> Self {
        Self {
            max_bytes: Some(max_bytes),
            ..Self::default()
        }
    }

    /// Whether cost and memory are within their bounds.
    pub fn affords(&self, milliseconds: f64, bytes: u64) -> bool {
        self.max_ms.is_none_or(|max| milliseconds <= max)
            && self.max_bytes.is_none_or(|max| bytes <= max)
    }

    /// Checks that there are bounds, and that they can be met.
    ///
    /// # Errors
    /// Errors if no bound is given, one is NaN or negative, or the error's bound is over 1.
    pub fn validate(&self) -> Result<(), Invalid> {
        if *self == Self::default() {
            return Err(Invalid::new(
                "bounds",
                "are missing",
                "give a greatest error, time or number of bytes",
            ));
        }
        if let Some(error) = self.max_error
            && !(0.0..=1.0).contains(&error)
        {
            let why = format!("is {error}");
            return Err(Invalid::new(
                "greatest error",
                why,
                "use 0 to 1, such as 0.05",
            ));
        }
        if let Some(ms) = self.max_ms
            && !(ms >= 0.0 && ms.is_finite())
        {
            let why = format!("is {ms}");
            let help = "use milliseconds, 0 or more";
            return Err(Invalid::new("greatest time", why, help));
        }
        Ok(())
    }
}

impl std::fmt::Display for Bounds {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let words = [
            self.max_error.map(|e| format!("error at most {e}")),
            self.max_ms.map(|ms| format!("at most {ms} ms")),
            self.max_bytes.map(|bytes| format!("at most {bytes} bytes")),
        ];
        f.write_str(&words.into_iter().flatten().collect::<Vec<_>>().join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::Bounds;

    #[test]
    fn bounds_that_bound_nothing_are_refused() {
        assert!(Bounds::default().validate().is_err());
        for e in [f64::NAN, -0.1, 1.1, f64::INFINITY] {
            assert!(Bounds::error(e).validate().is_err(), "{e}");
        }
        for ms in [f64::NAN, -1.0, f64::INFINITY] {
            assert!(Bounds::milliseconds(ms).validate().is_err(), "{ms}");
        }
        for bounds in [
            Bounds::error(0.0),
            Bounds::milliseconds(0.5),
            Bounds::bytes(0),
        ] {
            assert!(bounds.validate().is_ok(), "{bounds}");
        }
    }

    #[test]
    fn both_time_and_memory_must_be_within() {
        let bounds = Bounds {
            max_ms: Some(2.0),
            max_bytes: Some(100),
            ..Bounds::default()
        };
        assert!(bounds.affords(2.0, 100));
        assert!(!bounds.affords(2.1, 100) && !bounds.affords(2.0, 101));
    }
}
