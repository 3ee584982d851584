//! Coordinates relative to an ideal light: the face of a grid of cells, the position on it, and the
//! depth.
//!
//! **Frame space** has the light's rays as verticals. For a directional light, a point is (u, v,
//! w): two coordinates across the rays and one along them. They are divided by half the width of
//! all casters, so that u and v are within -1 to 1. For a point light, frame space is the world's
//! axes around the light, in metres.
//!
//! The **direction** of a point is (u, v, 1) for a directional light. For a point light it is the
//! point divided by its greatest coordinate, which is on the cube around the light. The **depth**
//! of a point is w minus that of the nearest caster, or the size of the greatest coordinate for a
//! point light. Both grow away from the light.
//!
//! **Margins.** A list may contain too many casters, but must contain all that a ray through its
//! cell may be found to hit. The triangle test has an error of some roundings of its distances
//! (`ray_triangle.rs` of `umbrage-core`), as does the rounding of coordinates. Boxes and depths are
//! widened by more than that.
//!
//! **Margins of a device's hierarchy** (`on_device/`) follow the distances, so that they are small
//! in large scenes. `u = 2^-24` is the greatest relative error of one rounding, `w` a caster's
//! longest side, and `D` the depth from the caster to a receiver in its shadow.
//!
//! * A position relative to the origin is rounded, then three products and their sum: an error of at
//!   most `5u` of its length across the rays, and `7u` along them. A caster is at most `R` from the
//!   origin, half the diagonal of the casters' box, and the receiver at most `R + D`. Together they
//!   err by at most `14u R + 7u D`. [`POSITION_MARGIN`] is `16u`, times `R`.
//! * By `ray_triangle.rs`, a ray that hits passes the caster within `6u (D + w)` along each of two
//!   axes: `8.5u (D + w)`, and some roundings of `w`. `TEST_ERROR` in WGSL is `32u`. Its part with w is
//!   added to the caster's rectangle. The part with D, and that of the receiver's position, is added
//!   by the lookup, times the depth below the node's nearest caster, which is at least D.
//! * The test's distance is a sum of the corners' coordinates along the ray's longest axis relative
//!   to the receiver, with weights of one sign: that of a point of the caster with the computed
//!   weights. This point is off the ray by its shift (next item). The ray's depth at its coordinate
//!   differs from its depth by at most the shift times the slope of the ray to the axis, `sqrt(2)`.
//!   So depths have a margin of `w / 512` (`SHIFT_DEPTH`), and `1.5w` for grazing casters.
//! * A strip has its own least depth. A hit has the depth of the point with the computed weights.
//!   Each weight has an error of at most `9u w^2`, of a sum that is at least `w^2 / 512` (`GRAZING`). So the
//!   point is at most `27u * 512 w`, or `w / 1,200`, from the exact one, and strips are a 512th of their
//!   length longer. Casters of less area have the least depth of all their corners.
//! * Around a point light, the same errors across the rays are divided by the depth of the hit,
//!   since a face has that size at the depth 1. The ray's direction rounds, too: by `4u D`. With `6u`
//!   that is a third of `TEST_ERROR`. The part with w is divided by the caster's least depth, and
//!   that with D by the node's. Rays end 2^-14 of their length before the light, which bounds it.
//!   A caster beyond the rim of a face, by less than the error for the farthest receivers, is on
//!   the rim. A whole caster needs no margin in depth but `LAMP_DEPTH_MARGIN`: the test against its
//!   box is exact along the face's axis.

use umbrage_core::{
    Aabb, Geometry, Light,
    glam::{DVec3, UVec2, UVec4, Vec2, Vec3, Vec4},
    light_sample::LightSampler,
    math::dot3,
    uniforms,
};

/// Least margin, in units of frame space across the rays: 64 roundings of 1. Coordinates and
/// outline functions have an error of some eight of them.
pub(super) const LEAST_MARGIN: f32 = 1.0 / 262_144.0;

/// Least margin of a directional light's positions on a device, as a fraction of the casters'
/// distance from the origin: 16 roundings. A position has an error of some five.
pub(super) const POSITION_MARGIN: f32 = 1.0 / 1_048_576.0;

/// Greatest error of the ray-triangle test, as a fraction of the farthest distance in the scene: 32
/// roundings of 2^-24, four times the bound in `ray_triangle.rs`.
const ROUNDING: f32 = 1.0 / 524_288.0;

/// Depth margin of a directional light over its margin across: outlines up to half as steep have a
/// valid depth.
const DEPTH_OVER_WIDTH: f32 = 16.0;

/// Depth margin of a point light, as a fraction of depth.
const LAMP_DEPTH_MARGIN: f32 = 1.0 / 4096.0;

/// Distance from a point light, as a fraction of the farthest distance in the scene, within which
/// casters may be before the end of a ray. Rays end at half of this distance from the light.
const AT_LAMP: f32 = 1.0 / 8192.0;

/// Minimum and maximum number of tiles along the longer side of a face, powers of two.
const TILES: [f32; 2] = [8.0, 128.0];

/// Number of triangles per tile, if they were evenly distributed over the square of the longest
/// side.
const TRIANGLES_A_TILE: f32 = 64.0;

/// Frame around an ideal light, or around the centre of an area light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightFrame {
    /// True if the light has a position, where its rays meet.
    pub(super) is_lamp: bool,
    /// World position of the origin of frame space: the point light, or the centre of the casters.
    pub(super) origin: Vec3,
    /// Rows of the matrix from the world (relative to the origin) to frame space.
    pub(super) rows: [Vec3; 3],
    /// Value subtracted from a directional light's w: the depth of the nearest caster.
    pub(super) nearest: f32,
    /// Half the size of a face, in units of a direction.
    pub(super) half: Vec2,
    /// Number of tiles per unit of a direction.
    pub(super) tiles_a_unit: f32,
    /// Number of tiles of a face, across and down.
    pub(super) tiles: UVec2,
    /// Greatest error of the triangle test, in units of frame space.
    pub(super) rounding: f32,
    /// Farthest distance between any points of the scene and the point light, in units of frame
    /// space.
    pub(super) reach: f32,
}

/// Point in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FramePoint {
    pub(super) face: u32,
    /// Across and down the face, within -half to half.
    pub(super) on_face: Vec2,
    pub(super) depth: f32,
}

uniforms! {
    /// Uniforms of [`ExactKernel`](crate::ExactKernel).
    pub struct ExactUniforms {
        /// Centre of the light, as an ideal light.
        pub light: LightSampler,
        /// The camera's position; w is unused.
        pub eye: Vec4,
        /// First row of the matrix from the world, relative to the origin, to frame space; w is
        /// unused.
        pub across: Vec4,
        /// Second row; w is unused.
        pub down: Vec4,
        /// Third row; w: value subtracted from a directional light's depth.
        pub away: Vec4,
        /// World position of frame space's origin; w is unused.
        pub origin: Vec4,
        /// Half the size of a face, across and down; tiles per unit of a direction; the reach
        /// of receivers, metres: [`Geometry::receiver_reach`](umbrage_core::Geometry::receiver_reach).
        pub grid: Vec4,
        /// Number of tiles of a face, across and down; 1 if the light has a position; 1 if receivers'
        /// triangles have the ids of casters, which a hierarchy's lookup needs to know.
        pub tiles: UVec4,
        /// Length of rays towards directional lights, metres.
        pub far: f32,
    }
}

impl LightFrame {
    /// Returns the frame of a light around the casters of a geometry. It contains at least one.
    pub(super) fn new(light: &Light, geometry: &Geometry) -> Self {
        let mut casters = geometry.caster_bounds();
        if casters.is_empty() {
            casters = Aabb::from_points([Vec3::ZERO]);
        }
        let tiles = tiles_along(geometry.casters().len());
        let axes = |away: DVec3| away.any_orthonormal_pair();
        Self::around_casters(light, axes, &casters, &geometry.bounds(), tiles)
    }

    /// Returns the frame of a light around casters in a box. `everything` is the box around the
    /// casters and all ray origins. `axes` returns the axes across the rays of a directional light,
    /// and `tiles` are those along its longer side.
    pub(super) fn around_casters(
        light: &Light,
        axes: impl Fn(DVec3) -> (DVec3, DVec3),
        casters: &Aabb,
        everything: &Aabb,
        tiles: u32,
    ) -> Self {
        match light.position() {
            Some(lamp) => Self::around_lamp(lamp, everything, tiles),
            None => {
                let away = -light.direction_from(Vec3::ZERO).as_dvec3();
                let (across, down) = axes(away);
                Self::along_sun([across, down, away], casters, everything, tiles)
            }
        }
    }

    /// Returns the distance from a point light within which casters may be anywhere; otherwise 0.
    pub(super) fn at_lamp(&self) -> f32 {
        if self.is_lamp {
            self.reach * AT_LAMP
        } else {
            0.0
        }
    }

    fn around_lamp(lamp: Vec3, everything: &Aabb, tiles: u32) -> Self {
        let with_lamp = everything.union(&Aabb::from_points([lamp]));
        let reach = with_lamp.diagonal();
        // Six faces share the triangles.
        let tiles = (tiles / 2).max(4);
        Self {
            is_lamp: true,
            origin: lamp,
            rows: [Vec3::X, Vec3::Y, Vec3::Z],
            nearest: 0.0,
            half: Vec2::ONE,
            tiles_a_unit: 0.5 * tiles as f32,
            tiles: UVec2::splat(tiles),
            rounding: reach * ROUNDING,
            reach,
        }
    }

    fn along_sun(axes: [DVec3; 3], casters: &Aabb, everything: &Aabb, tiles: u32) -> Self {
        // Measure the casters along the light's axes.
        let [across, down, away] = axes;
        let origin = casters.center();
        let corners: Vec<DVec3> = casters.corners().map(|c| (c - origin).as_dvec3()).collect();
        let extent = |axis: DVec3| {
            corners
                .iter()
                .map(|c| axis.dot(*c).abs())
                .fold(0.0, f64::max)
        };
        let [wide, high, deep] = [extent(across), extent(down), extent(away)];
        // A line or a point has no width: use any width, but keep the depth.
        let unit = wide
            .max(high)
            .max(deep * 1e-3)
            .max(f64::from(f32::MIN_POSITIVE));
        // Add a margin for rounding at the edge.
        let room = 1.0 + 1.0 / 1024.0;
        let half = Vec2::new((wide / unit) as f32, (high / unit) as f32) * room + LEAST_MARGIN;
        // Divide the face into tiles.
        let tiles_a_unit = 0.5 * tiles as f32;
        let count = (half * 2.0 * tiles_a_unit)
            .ceil()
            .as_uvec2()
            .max(UVec2::ONE);
        let reach = (f64::from(everything.diagonal()) / unit) as f32;
        Self {
            is_lamp: false,
            origin,
            rows: [across, down, away].map(|axis| (axis / unit).as_vec3()),
            nearest: -(deep / unit) as f32 * room - LEAST_MARGIN,
            half,
            tiles_a_unit,
            tiles: count,
            rounding: reach * ROUNDING,
            reach,
        }
    }

    /// Transforms a world position to frame space.
    #[inline(always)]
    pub(super) fn place(&self, p: Vec3) -> Vec3 {
        if self.is_lamp {
            self.place_as::<true>(p)
        } else {
            self.place_as::<false>(p)
        }
    }

    /// Transforms a world position to frame space, of a point light or a directional light.
    #[inline(always)]
    pub(super) fn place_as<const LAMP: bool>(&self, p: Vec3) -> Vec3 {
        let v = p - self.origin;
        if LAMP {
            return v;
        }
        Vec3::new(
            dot3(self.rows[0], v),
            dot3(self.rows[1], v),
            dot3(self.rows[2], v) - self.nearest,
        )
    }

    /// Returns the lookup coordinates of a point of frame space. For a point light, the face is
    /// that across `axis`.
    #[inline(always)]
    pub(super) fn look_up_as<const LAMP: bool>(&self, v: Vec3, axis: u32) -> FramePoint {
        if !LAMP {
            return FramePoint {
                face: 0,
                on_face: Vec2::new(v.x, v.y),
                depth: v.z,
            };
        }
        // Use selections instead of branches, so that loops over receivers are vectorised.
        let pick = |x: f32, y: f32, z: f32| {
            if axis == 0 {
                x
            } else if axis == 1 {
                y
            } else {
                z
            }
        };
        let along = pick(v.x, v.y, v.z);
        let direction = v / along.abs();
        let across = pick(direction.y, direction.z, direction.x);
        let down = pick(direction.z, direction.x, direction.y);
        FramePoint {
            face: 2 * axis + u32::from(along < 0.0),
            on_face: Vec2::new(across, down),
            depth: along.abs(),
        }
    }

    /// Returns the number of faces.
    pub(super) fn faces(&self) -> u32 {
        if self.is_lamp { 6 } else { 1 }
    }

    /// Returns the number of tiles of all faces.
    pub(super) fn tile_count(&self) -> usize {
        (self.faces() * self.tiles.x * self.tiles.y) as usize
    }

    /// Returns the greatest distance, in units of a direction, at which the triangle test may be
    /// wrong near an outline. `distance` is that of the outline's nearest point from the point
    /// light, metres. It is unused for directional lights.
    pub(super) fn margin(&self, distance: f32) -> f32 {
        if !self.is_lamp {
            return LEAST_MARGIN + self.rounding;
        }
        // The greatest coordinate is at least this fraction of the distance.
        const COORDINATE: f32 = 0.577;
        LEAST_MARGIN + self.rounding / (distance * COORDINATE)
    }

    /// Returns whether a ray may end before it hits a caster at this distance from the point light,
    /// metres.
    pub(super) fn is_at_lamp(&self, distance: f32) -> bool {
        distance < self.at_lamp()
    }

    /// Returns the margin in depth: in units of frame space for a directional light, as a fraction
    /// of the depth for a point light.
    pub(super) fn depth_margin(&self) -> f32 {
        if self.is_lamp {
            LAMP_DEPTH_MARGIN
        } else {
            DEPTH_OVER_WIDTH * self.margin(0.0)
        }
    }

    /// Returns the depth minus the margin.
    pub(super) fn depth_before(&self, depth: f32) -> f32 {
        if self.is_lamp {
            depth * (1.0 - self.depth_margin()) - self.rounding
        } else {
            self.before_under_sun(depth)
        }
    }

    /// Returns the depth minus the margin for a directional light, without testing the light's
    /// kind.
    #[inline(always)]
    pub(super) fn before_under_sun(&self, depth: f32) -> f32 {
        depth - DEPTH_OVER_WIDTH * (LEAST_MARGIN + self.rounding)
    }

    /// Returns the depth plus the margin.
    pub(super) fn depth_behind(&self, depth: f32) -> f32 {
        if self.is_lamp {
            depth * (1.0 + self.depth_margin()) + self.rounding
        } else {
            depth + self.depth_margin()
        }
    }

    /// Returns the least depth of a plane, minus the margin, from the least and the greatest value
    /// of its function.
    #[inline(always)]
    pub(super) fn nearest_of_plane(&self, least: f32, greatest: f32) -> f32 {
        if self.is_lamp {
            // The function is one over the depth.
            self.depth_before(1.0 / greatest.max(f32::MIN_POSITIVE))
        } else {
            self.depth_before(least)
        }
    }

    /// Returns [`nearest_of_plane`](Self::nearest_of_plane) for four planes.
    #[inline(always)]
    pub(super) fn four_nearest_of_plane(&self, least: Vec4, greatest: Vec4) -> Vec4 {
        if self.is_lamp {
            let nearest = greatest.max(Vec4::splat(f32::MIN_POSITIVE)).recip();
            nearest * (1.0 - self.depth_margin()) - self.rounding
        } else {
            least - self.depth_margin()
        }
    }

    /// Returns [`farthest_of_plane`](Self::farthest_of_plane) for four planes.
    #[inline(always)]
    pub(super) fn four_farthest_of_plane(&self, least: Vec4, greatest: Vec4) -> Vec4 {
        if !self.is_lamp {
            return greatest + self.depth_margin();
        }
        let farthest = least.recip() * (1.0 + self.depth_margin()) + self.rounding;
        Vec4::select(least.cmpgt(Vec4::ZERO), farthest, Vec4::INFINITY)
    }

    /// Returns the greatest depth of a plane, plus the margin, from the least and the greatest
    /// value of its function.
    #[inline(always)]
    pub(super) fn farthest_of_plane(&self, least: f32, greatest: f32) -> f32 {
        if !self.is_lamp {
            self.depth_behind(greatest)
        } else if least > 0.0 {
            self.depth_behind(1.0 / least)
        } else {
            f32::INFINITY
        }
    }
}

/// Returns the number of tiles along the longer side of a face.
fn tiles_along(casters: usize) -> u32 {
    let even = (casters as f32 / TRIANGLES_A_TILE).sqrt();
    let side = even.clamp(TILES[0], TILES[1]);
    (side.ceil() as u32).next_power_of_two()
}
