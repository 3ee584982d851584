//! Kinds of vertices that can be drawn, with the arithmetic of their transform.

use glam::{Mat4, Vec3, Vec4};
use umbrage_core::math::transform;

/// Order in which the four products of a vertex's transform to clip space are added. WGSL allows
/// devices to use another order than the source. Guarded products (`product4` in math.wgsl) only
/// prevent fusing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum VertexSums {
    /// From x to w, as in the shader source.
    #[default]
    InOrder,
    /// From w to x, each product and its sum rounded once.
    Fused,
    /// From w to x.
    Reversed,
    /// x and y, z and w, then both sums.
    Paired,
}

impl VertexSums {
    /// All orders except that of the source.
    pub const OTHERS: [Self; 3] = [Self::Fused, Self::Reversed, Self::Paired];

    /// Returns a homogeneous vertex in clip space.
    #[inline(always)]
    fn to_clip(self, v: Vec4, m: Mat4) -> Vec4 {
        let [x, y, z, w] = [
            m.x_axis * v.x,
            m.y_axis * v.y,
            m.z_axis * v.z,
            m.w_axis * v.w,
        ];
        let add = |axis: Vec4, by: f32, sum: Vec4| axis.mul_add(Vec4::splat(by), sum);
        match self {
            Self::InOrder => ((x + y) + z) + w,
            Self::Fused => add(m.x_axis, v.x, add(m.y_axis, v.y, add(m.z_axis, v.z, w))),
            Self::Reversed => x + (y + (z + w)),
            Self::Paired => (x + y) + (z + w),
        }
    }
}

/// Vertex in world space.
pub(crate) trait Position: Copy + Send + Sync {
    /// Returns the vertex in clip space: columns times components, added from left to right.
    fn to_clip(self, clip_from_world: Mat4) -> Vec4;

    /// Returns the vertex as a homogeneous point.
    fn homogeneous(self) -> Vec4;

    /// Returns the vertex in clip space, added in this order.
    fn to_clip_by(self, sums: VertexSums, clip_from_world: Mat4) -> Vec4 {
        match sums {
            VertexSums::InOrder => self.to_clip(clip_from_world),
            _ => sums.to_clip(self.homogeneous(), clip_from_world),
        }
    }
}

/// Point.
impl Position for Vec3 {
    #[inline(always)]
    fn to_clip(self, clip_from_world: Mat4) -> Vec4 {
        transform(clip_from_world, self)
    }

    fn homogeneous(self) -> Vec4 {
        self.extend(1.0)
    }
}

/// Homogeneous point; w = 0 is the point infinitely far along a direction.
impl Position for Vec4 {
    #[inline(always)]
    fn to_clip(self, m: Mat4) -> Vec4 {
        VertexSums::InOrder.to_clip(self, m)
    }

    fn homogeneous(self) -> Vec4 {
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_order_rounds_otherwise_and_by_little() {
        let m = Mat4::from_cols_array(&std::array::from_fn(|i| (i as f32 * 0.7).sin()));
        for i in 0..1000 {
            let p = 1e3 * Vec3::new(i as f32 * 0.37, 1.0 - i as f32 * 0.11, 7.0);
            let plain = p.to_clip(m);
            assert_eq!(plain, VertexSums::InOrder.to_clip(p.extend(1.0), m));
            // Entries of the matrix are at most 1. Three products and three sums are each rounded
            // by half a unit, in either direction.
            let greatest = 3.0 * p.abs().max_element() + 1.0;
            for sums in VertexSums::OTHERS {
                let error = (p.to_clip_by(sums, m) - plain).abs().max_element();
                assert!(error <= 6.0 * f32::EPSILON * greatest, "{sums:?}: {error}");
            }
        }
        let differs = |sums: VertexSums| {
            let points = (0..100).map(|i| Vec3::new(1e4, i as f32 + 0.1, 3.3));
            let differing = points.filter(|p| p.to_clip(m) != p.to_clip_by(sums, m));
            differing.count()
        };
        for sums in VertexSums::OTHERS {
            assert!(differs(sums) > 10, "{sums:?}");
        }
    }
}
