//! Fused multiply-add behaviour of devices.

use std::fmt;

/// Rounding of a product and a sum by a device's fragment shaders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct Fusing {
    /// True if `a * b + c` is rounded once.
    pub product_and_sum: bool,
    /// True if `fma(a, b, c)` is rounded once.
    pub fma: bool,
    /// True if the sum of `product(a, b)` of `math.wgsl` and `c` is rounded once. This must be
    /// false: shadow tests rely on it. `None` if unknown, as in older device files.
    #[cfg_attr(feature = "serde", serde(default))]
    pub guarded_product: Option<bool>,
}

/// Formats as `a * b + c is rounded twice, fma(a, b, c) twice`.
impl fmt::Display for Fusing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let times = |is_fused| if is_fused { "once" } else { "twice" };
        let sum = times(self.product_and_sum);
        let fma = times(self.fma);
        write!(f, "a * b + c is rounded {sum}, fma(a, b, c) {fma}")?;
        if self.guarded_product == Some(true) {
            write!(
                f,
                "; product(a, b) + c once: masks may differ from the CPU's"
            )?;
        }
        Ok(())
    }
}
