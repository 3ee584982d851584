//! Vertex rounding of rasterisers.
//!
//! Rasterisers snap vertices to a grid of 2^b steps a pixel before they decide which pixels a
//! triangle covers. Vulkan and WebGPU require b >= 4; most hardware has 8. Some drivers also
//! compute the triangle's depth plane from the snapped vertices, which changes depths by up to half
//! a step times the plane's slope. The unit of polygon offset also depends on the device.

use crate::invalid::Invalid;
use std::{fmt, ops::RangeInclusive};

/// Vertex rounding and polygon offset unit of a rasteriser. The default is that of Mesa's software
/// drivers, which the CPU backend follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct Snapping {
    /// Binary digits of the sub-pixel grid, 4 to 8: vertices are multiples of 2^-bits pixels.
    pub sub_pixel_bits: u32,
    /// Vertices that define depth planes.
    pub planes: DepthPlanes,
    /// Unit of polygon offset in 16-bit images.
    #[cfg_attr(feature = "serde", serde(default))]
    pub offset_unit: OffsetUnit,
}

/// Unit of polygon offset in 16-bit images. Vulkan leaves it to devices ("minimum resolvable
/// difference").
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum OffsetUnit {
    /// One step of the image's depths, as in hardware and SwiftShader.
    OneStep,
    /// Two steps, as in Mesa's software drivers.
    #[default]
    TwoSteps,
}

impl OffsetUnit {
    /// Returns the unit as a difference of depths, 0..1.
    pub const fn depth(self) -> f32 {
        match self {
            Self::OneStep => 1.0 / 65_535.0,
            Self::TwoSteps => 2.0 / 65_535.0,
        }
    }
}

/// Vertices that define depth planes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum DepthPlanes {
    /// Unsnapped vertices: depths don't depend on the grid.
    #[default]
    Unsnapped,
    /// Snapped vertices.
    Snapped,
}

impl Snapping {
    /// Supported numbers of binary digits. No graphics API allows fewer, and finer grids count as
    /// the finest.
    pub const BITS: RangeInclusive<u32> = 4..=8;

    /// The coarsest rounding that graphics APIs allow: the assumption for unknown devices.
    pub const COARSEST: Self = Self {
        sub_pixel_bits: 4,
        planes: DepthPlanes::Snapped,
        offset_unit: OffsetUnit::OneStep,
    };

    /// Returns the grid step, pixels.
    pub fn step(self) -> f32 {
        1.0 / (1_u32 << self.sub_pixel_bits) as f32
    }

    /// Checks that the grid is supported.
    ///
    /// # Errors
    /// Errors if the number of bits is not among [`Snapping::BITS`].
    pub fn validate(self) -> Result<(), Invalid> {
        if Self::BITS.contains(&self.sub_pixel_bits) {
            return Ok(());
        }
        let help = format!("use {} to {}", Self::BITS.start(), Self::BITS.end());
        Err(Invalid::new(
            "number of sub-pixel bits",
            format!("is {}", self.sub_pixel_bits),
            help,
        ))
    }
}

impl Default for Snapping {
    fn default() -> Self {
        Self {
            sub_pixel_bits: 8,
            planes: DepthPlanes::Unsnapped,
            offset_unit: OffsetUnit::TwoSteps,
        }
    }
}

/// Formats as `8 sub-pixel bits, depth planes through unsnapped vertices, 16-bit polygon offsets in
/// units of 2/65535`.
impl fmt::Display for Snapping {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let through = match self.planes {
            DepthPlanes::Unsnapped => "unsnapped",
            DepthPlanes::Snapped => "snapped",
        };
        let unit = match self.offset_unit {
            OffsetUnit::OneStep => "1/65535",
            OffsetUnit::TwoSteps => "2/65535",
        };
        let bits = self.sub_pixel_bits;
        write!(
            f,
            "{bits} sub-pixel bits, depth planes through {through} vertices, 16-bit polygon offsets in units of {unit}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_known_grids_are_valid() {
        let of = |sub_pixel_bits| Snapping {
            sub_pixel_bits,
            ..Snapping::default()
        };
        for bits in 4..=8 {
            assert_eq!(of(bits).validate(), Ok(()));
        }
        for bits in [0, 3, 9, u32::MAX] {
            let why = of(bits).validate().expect_err("not known").to_string();
            assert!(why.contains(&format!("is {bits}; use 4 to 8")), "{why}");
        }
    }

    #[test]
    fn steps_and_words() {
        assert_eq!(
            (Snapping::default().step(), Snapping::COARSEST.step()),
            (1.0 / 256.0, 1.0 / 16.0)
        );
        let words = Snapping::COARSEST.to_string();
        assert_eq!(
            words,
            "4 sub-pixel bits, depth planes through snapped vertices, 16-bit polygon offsets in units of 1/65535"
        );
    }
}
