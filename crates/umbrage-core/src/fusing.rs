//! Whether devices round a product before it goes into a sum.

use std::fmt;

/// What a device does with a product and a sum in fragment shaders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct Fusing {
    /// Whether `a * b + c` is rounded once.
    pub product_and_sum: bool,
    /// Whether `fma(a, b, c)` is rounded once.
    pub fma: bool,
    /// Whether the sum of `product(a, b)` of `math.wgsl` and `c` is rounded once. This must be
    /// false: what decides whether a point is lit relies on it. `None` if unknown: older files of
    /// cards lack it.
    #[cfg_attr(feature = "serde", serde(default))]
    pub guarded_product: Option<bool>,
}

/// `a * b + c is rounded twice, fma(a, b, c) twice`
impl fmt::Display for Fusing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let times = |is_fused| if is_fused { "once" } else { "twice" };
        let sum = times(self.product_and_sum);
        let fma = times(self.fma);
        write!(f, "a * b + c is rounded {sum}, fma(a, b, c) {fma}")?;
        if self.guarded_product == Some(true) {
            write!(
                f,
                "; product(a, b) + c once, so masks may differ from the CPU's"
            )?;
        }
        Ok(())
    }
}
