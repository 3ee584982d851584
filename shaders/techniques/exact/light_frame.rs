//! Where points lie as seen from an ideal light: on which face of a grid of cells, where on it, and
//! how deep.
//!
//! **Frame space** has the light's rays as verticals. For a sun a point is (u, v, w): two
//! coordinates across the rays and one along them, over half the width of all casters, so that u
//! and v are within -1 to 1. For a lamp it is the world's axes around the light, in metres.
//!
//! A point's **direction** is (u, v, 1) for a sun, and for a lamp the point over its greatest
//! coordinate, which is a point of the cube around the light. Its **depth** is w less that of the
//! nearest caster, or for a lamp that greatest coordinate's size: both grow away from the light.
//!
//! **Margins.** A list may hold too many casters, but must hold all that a ray through its cell may
//! be found to meet. What the triangle test finds is off by some roundings of the distances in it
//! (`ray_triangle.rs` of `umbrage-core`), and so is where coordinates are rounded to: boxes and
//! depths are widened by more than that.

use umbrage_core::{
    Aabb, Geometry, Light,
    glam::{DVec3, UVec2, Vec2, Vec3, Vec4},
    math::dot3,
};

/// Least margin, in units of frame space across the rays: 64 roundings of 1, the most that
/// coordinates and the functions of outlines are wrong by (some eight of them).
pub(super) const LEAST_MARGIN: f32 = 1.0 / 262_144.0;

/// What the triangle test of rays is wrong by at most, as a fraction of the farthest distance in
/// the scene: 32 roundings of 2^-24, four times what `ray_triangle.rs` shows.
const ROUNDING: f32 = 1.0 / 524_288.0;

/// A sun's margin in depth over the margin across: outlines up to half as steep know their depth.
const DEPTH_OVER_WIDTH: f32 = 16.0;

/// A lamp's margin in depth, as a fraction of depth.
const LAMP_DEPTH_MARGIN: f32 = 1.0 / 4096.0;

/// Casters nearer to a lamp than this fraction of the farthest distance in the scene may lie before
/// the end of a ray, which stops short of the lamp by half of this.
const AT_LAMP: f32 = 1.0 / 8192.0;

/// Tiles along the longer side of a face: a power of two, at least and at most.
const TILES: [f32; 2] = [8.0, 128.0];

/// Triangles of a tile, if they were spread evenly over the longest side's square.
const TRIANGLES_A_TILE: f32 = 64.0;

/// A frame around an ideal light, or around the middle of one with an extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightFrame {
    /// Whether the light has a place, so that its rays meet there.
    pub(super) is_lamp: bool,
    /// World position that is the origin of frame space: the lamp, or the middle of the casters.
    pub(super) origin: Vec3,
    /// Rows of the matrix from the world (less the origin) to frame space.
    pub(super) rows: [Vec3; 3],
    /// What is subtracted from a sun's w: the depth of the nearest caster.
    pub(super) nearest: f32,
    /// Half the size of a face, in units of a direction.
    pub(super) half: Vec2,
    /// Tiles a unit of a direction.
    pub(super) tiles_a_unit: f32,
    /// Tiles of a face, across and down.
    pub(super) tiles: UVec2,
    /// What the triangle test is wrong by at most, in units of frame space.
    pub(super) rounding: f32,
    /// The farthest distance between two points of the scene and the lamp, in units of frame space.
    pub(super) reach: f32,
}

/// A point in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FramePoint {
    pub(super) face: u32,
    /// Across and down the face, within -half to half.
    pub(super) on_face: Vec2,
    pub(super) depth: f32,
}

impl LightFrame {
    /// Returns the frame of a light around the casters of a geometry, at least one.
    pub(super) fn new(light: &Light, geometry: &Geometry) -> Self {
        let mut casters = geometry.caster_bounds();
        if casters.is_empty() {
            casters = Aabb::around([Vec3::ZERO]);
        }
        let tiles = tiles_along(geometry.casters().len());
        Self::around(light, &casters, &geometry.bounds(), tiles)
    }

    /// Returns the frame of a light around casters in a box. `everything` is the box around all
    /// that rays start from, too; `tiles` are those along a sun's longer side.
    pub(super) fn around(light: &Light, casters: &Aabb, everything: &Aabb, tiles: u32) -> Self {
        match light.position() {
            Some(lamp) => Self::around_lamp(lamp, everything, tiles),
            None => Self::along_sun(light.direction_from(Vec3::ZERO), casters, everything, tiles),
        }
    }

    /// Returns the distance from a lamp within which casters may be anywhere.
    pub(super) fn at_lamp(&self) -> f32 {
        if self.is_lamp {
            self.reach * AT_LAMP
        } else {
            0.0
        }
    }

    fn around_lamp(lamp: Vec3, everything: &Aabb, tiles: u32) -> Self {
        let with_lamp = everything.union(&Aabb::around([lamp]));
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

    fn along_sun(to_light: Vec3, casters: &Aabb, everything: &Aabb, tiles: u32) -> Self {
        let away = -to_light.as_dvec3();
        let (across, down) = away.any_orthonormal_pair();
        let origin = casters.center();
        let corners: Vec<DVec3> = casters.corners().map(|c| (c - origin).as_dvec3()).collect();
        let extent = |axis: DVec3| {
            corners
                .iter()
                .map(|c| axis.dot(*c).abs())
                .fold(0.0, f64::max)
        };
        let [wide, high, deep] = [extent(across), extent(down), extent(away)];
        // A line or a point has no width: then any does, and the depth has one.
        let unit = wide
            .max(high)
            .max(deep * 1e-3)
            .max(f64::from(f32::MIN_POSITIVE));
        // Room for rounding at the rim.
        let room = 1.0 + 1.0 / 1024.0;
        let half = Vec2::new((wide / unit) as f32, (high / unit) as f32) * room + LEAST_MARGIN;
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

    /// Returns a world position in frame space.
    #[inline(always)]
    pub(super) fn place(&self, p: Vec3) -> Vec3 {
        if self.is_lamp {
            self.place_as::<true>(p)
        } else {
            self.place_as::<false>(p)
        }
    }

    /// Returns a world position in frame space, of a lamp or of a sun.
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

    /// Returns where a point of frame space is looked up, in the frame of a sun, or in that of a
    /// lamp on the face across `axis`.
    #[inline(always)]
    pub(super) fn look_up_as<const LAMP: bool>(&self, v: Vec3, axis: u32) -> FramePoint {
        if !LAMP {
            return FramePoint {
                face: 0,
                on_face: Vec2::new(v.x, v.y),
                depth: v.z,
            };
        }
        // Selections instead of branches, so that a loop over receivers becomes one of vector
        // instructions.
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

    /// Returns how far, in units of a direction, a ray may pass an outline whose nearest point is
    /// `distance` from the lamp, metres (a sun's outlines are all alike), and still be found to
    /// meet it, or to miss it.
    pub(super) fn margin(&self, distance: f32) -> f32 {
        if !self.is_lamp {
            return LEAST_MARGIN + self.rounding;
        }
        // The greatest coordinate is at least this much of the distance.
        const COORDINATE: f32 = 0.577;
        LEAST_MARGIN + self.rounding / (distance * COORDINATE)
    }

    /// Returns whether a ray may end before it meets a caster at this distance from the lamp,
    /// metres.
    pub(super) fn is_at_lamp(&self, distance: f32) -> bool {
        distance < self.at_lamp()
    }

    /// Returns the margin in depth: in units of frame space for a sun, as a fraction of the depth
    /// for a lamp.
    pub(super) fn depth_margin(&self) -> f32 {
        if self.is_lamp {
            LAMP_DEPTH_MARGIN
        } else {
            DEPTH_OVER_WIDTH * self.margin(0.0)
        }
    }

    /// Returns a depth that is surely less, by the margin.
    pub(super) fn before(&self, depth: f32) -> f32 {
        if self.is_lamp {
            depth * (1.0 - self.depth_margin()) - self.rounding
        } else {
            self.before_under_sun(depth)
        }
    }

    /// Returns the same of a sun, without asking what the light is.
    #[inline(always)]
    pub(super) fn before_under_sun(&self, depth: f32) -> f32 {
        depth - DEPTH_OVER_WIDTH * (LEAST_MARGIN + self.rounding)
    }

    /// Returns a depth that is surely greater, by the margin.
    pub(super) fn behind(&self, depth: f32) -> f32 {
        if self.is_lamp {
            depth * (1.0 + self.depth_margin()) + self.rounding
        } else {
            depth + self.depth_margin()
        }
    }

    /// Returns the least depth of a plane, less the margin, from the least and the greatest value
    /// of its function.
    #[inline(always)]
    pub(super) fn nearest_of_plane(&self, least: f32, greatest: f32) -> f32 {
        if self.is_lamp {
            // The function is one over the depth.
            self.before(1.0 / greatest.max(f32::MIN_POSITIVE))
        } else {
            self.before(least)
        }
    }

    /// Returns what [`nearest_of_plane`](Self::nearest_of_plane) does, of four planes.
    #[inline(always)]
    pub(super) fn four_nearest_of_plane(&self, least: Vec4, greatest: Vec4) -> Vec4 {
        if self.is_lamp {
            let nearest = greatest.max(Vec4::splat(f32::MIN_POSITIVE)).recip();
            nearest * (1.0 - self.depth_margin()) - self.rounding
        } else {
            least - self.depth_margin()
        }
    }

    /// Returns what [`farthest_of_plane`](Self::farthest_of_plane) does, of four planes.
    #[inline(always)]
    pub(super) fn four_farthest_of_plane(&self, least: Vec4, greatest: Vec4) -> Vec4 {
        if !self.is_lamp {
            return greatest + self.depth_margin();
        }
        let farthest = least.recip() * (1.0 + self.depth_margin()) + self.rounding;
        Vec4::select(least.cmpgt(Vec4::ZERO), farthest, Vec4::INFINITY)
    }

    /// Returns the greatest depth of a plane, and the margin, from the least and the greatest value
    /// of its function.
    #[inline(always)]
    pub(super) fn farthest_of_plane(&self, least: f32, greatest: f32) -> f32 {
        if !self.is_lamp {
            self.behind(greatest)
        } else if least > 0.0 {
            self.behind(1.0 / least)
        } else {
            f32::INFINITY
        }
    }
}

/// Returns how many tiles a face has along its longer side.
fn tiles_along(casters: usize) -> u32 {
    let even = (casters as f32 / TRIANGLES_A_TILE).sqrt();
    let side = even.clamp(TILES[0], TILES[1]);
    (side.ceil() as u32).next_power_of_two()
}
