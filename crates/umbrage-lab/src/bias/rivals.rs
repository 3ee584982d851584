//! Candidate biases of manual tuning.

use std::f32::consts::SQRT_2;
use umbrage_core::RasterBias;
use umbrage_techniques::Bias;

/// Constant biases, clip depth.
const CONSTANTS: [f32; 7] = [1e-5, 1e-4, 3e-4, 1e-3, 2e-3, 5e-3, 1e-2];
/// Slope biases relative to those of textbooks, `.05 / .005`, which come last.
const SLOPES: [f32; 4] = [0.003, 0.03, 0.3, 1.0];
/// Normal offsets relative to the one that prevents acne on a plane.
const OFFSETS: [f32; 6] = [0.25, 0.5, 0.75, 1.0, 1.5, 2.0];
/// Polygon offsets relative to the one that prevents acne on a plane.
const POLYGON_OFFSETS: [f32; 5] = [0.25, 0.5, 1.0, 1.5, 2.0];
/// Normal offsets in addition to the receiver plane, texels.
const OFF_PLANE_TEXELS: [f32; 4] = [0.0, 0.25, 0.5, 1.0];

/// Returns all kinds of bias except [`Bias::ADAPTIVE`] in many amounts, for a kernel that reaches
/// `reach` texels beyond the receiver's own.
pub fn rivals(reach: f32) -> Vec<Bias> {
    let constants = CONSTANTS.map(|constant| Bias {
        constant,
        ..Bias::NONE
    });
    let slopes = SLOPES.map(|share| Bias {
        slope: share * Bias::SLOPE.slope,
        slope_min: share * Bias::SLOPE.slope_min,
        ..Bias::NONE
    });
    let normal = OFFSETS.map(|share| Bias {
        normal_offset: share * (reach + 0.5) * SQRT_2,
        ..Bias::NORMAL_OFFSET
    });
    let polygon = POLYGON_OFFSETS.map(|share| Bias {
        raster: RasterBias {
            slope: share * (2.0 * reach + 1.0),
            ..Bias::POLYGON_OFFSET.raster
        },
        ..Bias::NONE
    });
    let plane = OFF_PLANE_TEXELS.map(|normal_offset| Bias {
        normal_offset,
        ..Bias::RECEIVER_PLANE
    });
    let plane_and_polygon = [0.5, 1.0, 2.0].map(|slope| Bias {
        raster: RasterBias {
            slope,
            ..Bias::POLYGON_OFFSET.raster
        },
        ..Bias::RECEIVER_PLANE
    });
    [
        &constants[..],
        &slopes,
        &normal,
        &polygon,
        &plane,
        &plane_and_polygon,
    ]
    .concat()
}
