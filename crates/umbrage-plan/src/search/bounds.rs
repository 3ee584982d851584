//! Bounds of a plan: error, grain, shimmer, time and memory, and the data of the renderer.

use crate::estimate::scene::RendererData;
use serde::{Deserialize, Serialize};
use umbrage_core::Invalid;

/// Greatest error, time and memory that shadows may have.
///
/// `None` means unbounded. At least one bound of error, time or memory is required.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Bounds {
    /// Greatest root mean square of mask - truth over the pixels that count, 0..=1.
    pub max_error: Option<f64>,
    /// Greatest root mean square of mask - truth relative to that of no shadow at all, 0..=1. It
    /// adapts to the amount of shadow in the image. With several cameras each has its own.
    pub max_relative_error: Option<f64>,
    /// Greatest predicted time of a frame's shadows, milliseconds. The
    /// [motion](super::PlanOptions::motion) decides which work each frame does.
    pub max_ms: Option<f64>,
    /// Greatest number of bytes of images and tables.
    pub max_bytes: Option<u64>,
    /// Greatest [grain](crate::Setting::grain) in penumbrae, 0..=1.
    pub max_grain: Option<f64>,
    /// Greatest [shimmer](crate::Setting::shimmer), 0..=1. Stable fits are candidates only if this
    /// is set.
    pub max_shimmer: Option<f64>,
    /// Data that the program has when it builds the recipes.
    pub renderer: RendererData,
}

/// The grain that [`Bounds::error`] and the commands allow. 16 rays a pixel and maps with smooth
/// kernels stay below it. 4 to 6 rays a pixel exceed it (`search/tests.rs` measures both).
pub const MAX_GRAIN: f64 = 0.06;

impl Bounds {
    /// Returns a bound of the error and the default bound of the grain ([`MAX_GRAIN`]). The plan is
    /// the cheapest technique within both.
    pub fn error(max_error: f64) -> Self {
        Self {
            max_error: Some(max_error),
            max_grain: Some(MAX_GRAIN),
            ..Self::default()
        }
    }

    /// Returns a bound of the error relative to that of no shadow, and the default bound of the
    /// grain ([`MAX_GRAIN`]). The plan is the cheapest technique within both.
    pub fn relative_error(max_relative_error: f64) -> Self {
        Self {
            max_relative_error: Some(max_relative_error),
            max_grain: Some(MAX_GRAIN),
            ..Self::default()
        }
    }

    /// Returns a bound of the time. The plan is the most accurate technique within it.
    pub fn milliseconds(max_ms: f64) -> Self {
        Self {
            max_ms: Some(max_ms),
            ..Self::default()
        }
    }

    /// Returns a bound of the memory. The plan is the most accurate technique within it.
    pub fn bytes(max_bytes: u64) -> Self {
        Self {
            max_bytes: Some(max_bytes),
            ..Self::default()
        }
    }

    /// Returns whether cost and memory are within their bounds.
    pub fn affords(&self, milliseconds: f64, bytes: u64) -> bool {
        self.max_ms.is_none_or(|max| milliseconds <= max)
            && self.max_bytes.is_none_or(|max| bytes <= max)
    }

    /// Returns whether there is a bound of the error, absolute or relative.
    pub fn has_error(&self) -> bool {
        self.max_error.is_some() || self.max_relative_error.is_some()
    }

    /// Returns whether a setting is within the bounds of grain and shimmer. Figures that were not
    /// measured count as within.
    pub fn allows_noise(&self, grain: Option<f64>, shimmer: Option<f64>) -> bool {
        let is_within = |figure: Option<f64>, max: Option<f64>| match (figure, max) {
            (Some(figure), Some(max)) => figure <= max,
            _ => true,
        };
        is_within(grain, self.max_grain) && is_within(shimmer, self.max_shimmer)
    }

    /// Checks that bounds are given and can be met.
    ///
    /// # Errors
    /// Errors if no bound of error, time or memory is given, one is NaN or negative, or a bound of
    /// an error, the grain or the shimmer is over 1.
    pub fn validate(&self) -> Result<(), Invalid> {
        if !self.has_error() && self.max_ms.is_none() && self.max_bytes.is_none() {
            return Err(Invalid::new(
                "bounds",
                "are missing",
                "give a greatest error, time or number of bytes",
            ));
        }
        for (what, max) in [
            ("greatest error", self.max_error),
            ("greatest relative error", self.max_relative_error),
            ("greatest grain", self.max_grain),
            ("greatest shimmer", self.max_shimmer),
        ] {
            if let Some(max) = max
                && !(0.0..=1.0).contains(&max)
            {
                let why = format!("is {max}");
                return Err(Invalid::new(what, why, "use 0 to 1, such as 0.05"));
            }
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
            self.max_relative_error
                .map(|e| format!("error at most {e} of that without shadows")),
            self.max_ms.map(|ms| format!("at most {ms} ms")),
            self.max_bytes.map(|bytes| format!("at most {bytes} bytes")),
            self.max_grain.map(|grain| format!("grain at most {grain}")),
            self.max_shimmer
                .map(|shimmer| format!("shimmer at most {shimmer}")),
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
    fn grain_alone_is_no_bound() {
        let grain = Bounds {
            max_grain: Some(0.1),
            ..Bounds::default()
        };
        assert!(grain.validate().is_err());
        assert!(Bounds::relative_error(0.3).validate().is_ok());
        assert!(Bounds::relative_error(1.5).validate().is_err());
        let bad_grain = Bounds {
            max_grain: Some(f64::NAN),
            ..Bounds::milliseconds(1.0)
        };
        assert!(bad_grain.validate().is_err());
    }

    #[test]
    fn what_was_not_measured_is_within() {
        let bounds = Bounds {
            max_shimmer: Some(0.01),
            ..Bounds::error(0.1)
        };
        assert!(bounds.allows_noise(None, None) && bounds.allows_noise(Some(0.0), Some(0.01)));
        assert!(!bounds.allows_noise(Some(0.5), None) && !bounds.allows_noise(None, Some(0.02)));
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
