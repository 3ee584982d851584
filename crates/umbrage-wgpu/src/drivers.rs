//! The driver with which both backends are bit-equal, and workarounds for its behaviour.
//!
//! Code that depends on a [`Workaround`] refers to it; no other code depends on a driver.
//! `tests/backend/drivers.rs` runs each one on the pinned driver and fails once that driver no
//! longer needs it. Then remove the rule and the workaround.

use crate::backend::Gpu;
use std::sync::Once;

/// The driver's `driver_info`.
pub const PINNED_DRIVER: &str = "Mesa 22.3.6 (LLVM 15.0.6)";

/// Environment variable that makes tests fail on other drivers if its value is `required`. CI sets
/// it.
pub const PINNED_DRIVER_VARIABLE: &str = "UMBRAGE_PINNED_DRIVER";

/// A driver's behaviour, and the rule by which code avoids it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Workaround {
    /// The driver, and the version in which the symptom was observed.
    pub driver: &'static str,
    /// Behaviour of the driver.
    pub symptom: &'static str,
    /// Rule by which code avoids it, with its location.
    pub rule: &'static str,
}

const LAVAPIPE: &str = "Mesa's lavapipe 22.3";

/// Loops end early.
pub const SHORT_LOOPS: Workaround = Workaround {
    driver: LAVAPIPE,
    symptom: "ends all loops of an invocation after 65,535 turns, those of its eight neighbours counted together",
    rule: "soft/hidden.wgsl tests two rows of the light and treats others as open",
};

/// Sums are reordered.
pub const SUM_ORDER: Workaround = Workaround {
    driver: LAVAPIPE,
    symptom: "adds a + (b * c + d * e) from left to right",
    rule: "`padded_box` in ray_box.rs pads by a maximum, not by a sum",
};

/// Shaders are compiled again.
pub const STEADY_FIRST_WORD: Workaround = Workaround {
    driver: LAVAPIPE,
    symptom: "compiles a shader that branches on the first word of a uniform buffer again for the first values of that word",
    rule: "uniform structs begin with a word that does not depend on the light",
};

impl Gpu {
    /// Checks that the adapter is the software driver to which the CPU backend is bit-equal. That
    /// is lavapipe of Mesa 22.3.6 on a processor with fused multiply-add, which its rasteriser uses
    /// if available.
    ///
    /// # Errors
    /// Errors with the driver's name if it is another one.
    pub fn check_pinned_driver(&self) -> Result<(), String> {
        check(&self.adapter_info().driver_info, has_fused_multiply_add())
    }

    /// Returns whether the adapter is the driver of [`Gpu::check_pinned_driver`] and shaders are
    /// not rewritten. For another driver, prints its name, and that bits are not compared.
    ///
    /// Panics if it is another driver and the environment variable `UMBRAGE_PINNED_DRIVER` is
    /// `required`.
    pub fn promises_bits(&self) -> bool {
        if crate::driver_model::is_set() {
            return false;
        }
        let Err(why) = self.check_pinned_driver() else {
            return true;
        };
        let required = std::env::var(PINNED_DRIVER_VARIABLE).is_ok_and(|value| value == "required");
        assert!(
            !required,
            "{PINNED_DRIVER_VARIABLE} is `required`, but {why}"
        );
        static SAID: Once = Once::new();
        SAID.call_once(|| println!("bits are not compared, only decided pixels: {why}"));
        false
    }
}

/// Errors if the driver is a different one, or the processor has no fused multiply-add.
fn check(driver: &str, fused: bool) -> Result<(), String> {
    if driver != PINNED_DRIVER {
        return Err(format!(
            "the driver is `{driver}`, and bits are promised on `{PINNED_DRIVER}`"
        ));
    }
    if !fused {
        return Err("the processor has no fused multiply-add".to_owned());
    }
    Ok(())
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fn has_fused_multiply_add() -> bool {
    std::arch::is_x86_feature_detected!("fma")
}

#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
fn has_fused_multiply_add() -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::{PINNED_DRIVER, check};

    #[test]
    fn other_drivers_are_named() {
        assert_eq!(check(PINNED_DRIVER, true), Ok(()));
        let other = check("Mesa 23.1.0 (LLVM 16.0.0)", true).expect_err("another driver");
        assert!(other.contains("Mesa 23.1.0"), "{other}");
        assert!(check(PINNED_DRIVER, false).is_err());
    }
}
