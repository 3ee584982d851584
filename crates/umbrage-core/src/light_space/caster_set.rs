//! Sets of casters for the layers of a shadow map.

use crate::{
    geometry::{Geometry, aabb::Aabb},
    light_space::{LightSpace, view_box},
};
use glam::{DMat4, DVec3, DVec4};
use std::{ops::Range, sync::Arc};

/// Greatest gap between runs that is drawn anyway, as a share of all casters. It limits the number
/// of runs, and so of draw calls.
const SMALLEST_GAP: f64 = 1.0 / 64.0;

/// Set of a scene's casters to draw.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum CasterSet {
    /// All casters.
    #[default]
    All,
    /// Rising ranges of the geometry's list of triangles, with gaps between them; empty for no
    /// casters.
    Runs(Arc<[Range<u32>]>),
}

impl CasterSet {
    /// Returns the empty set.
    pub fn none() -> Self {
        Self::Runs(Arc::new([]))
    }

    /// Returns whether there is nothing to draw.
    pub fn is_empty(&self) -> bool {
        matches!(self, Self::Runs(runs) if runs.is_empty())
    }

    /// Returns the casters that may be visible in a map of `size` x `size` texels in `space`. These
    /// are all runs of triangles whose boxes are not entirely outside the map's sides. Drawing the
    /// others would change no texel.
    pub fn shown_in(geometry: &Geometry, space: &LightSpace, size: u32) -> Self {
        let casters = geometry.casters();
        let smallest_gap = f64::from(casters.end - casters.start) * SMALLEST_GAP;
        let sides = sides_of(space, size);
        let mut runs: Vec<Range<u32>> = Vec::new();
        let mut walk = geometry.box_tree().walk(casters.clone());
        while let Some(block) = walk.next() {
            let Some(run) = block.run.clone() else {
                if !is_group_outside(&block.bounds, &sides) {
                    walk.enter(&block);
                }
                continue;
            };
            if is_box_outside(&block.bounds, &sides) {
                continue;
            }
            match runs.last_mut() {
                Some(last) if f64::from(run.start - last.end) < smallest_gap => last.end = run.end,
                _ => runs.push(run),
            }
        }
        if runs == [casters] {
            return Self::All;
        }
        Self::Runs(runs.into())
    }
}

/// Returns the four sides of a map as planes. The product of a plane with a homogeneous world
/// position is not negative on the map and within one texel around it. (Rasterisers move corners by
/// less than a texel: Vulkan requires at least 4 sub-pixel bits.)
fn sides_of(space: &LightSpace, size: u32) -> [DVec4; 4] {
    let clip_from_world: DMat4 = space.clip_from_world().as_dmat4();
    let world_from_clip_rows = clip_from_world.transpose();
    let x = world_from_clip_rows.x_axis;
    let y = world_from_clip_rows.y_axis;
    // The map spans two units of clip space.
    let one_texel = 2.0 / f64::from(size.max(1));
    let w = world_from_clip_rows.w_axis * (1.0 + one_texel);
    // Extract the planes as in Gribb and Hartmann 2001, "Fast extraction of viewing frustum planes
    // from the world-view-projection matrix".
    [w + x, w - x, w + y, w - y]
}

/// Returns whether a box is entirely on the outer side of one of the planes; false for NaN.
fn is_box_outside(bounds: &Aabb, sides: &[DVec4; 4]) -> bool {
    sides.iter().any(|side| farthest_inside(bounds, side) < 0.0)
}

/// Returns whether a box is so far outside one of the planes that [`is_box_outside`] is true of
/// every box in it, despite rounding.
fn is_group_outside(bounds: &Aabb, sides: &[DVec4; 4]) -> bool {
    let reach: DVec3 = bounds.min.abs().max(bounds.max.abs()).as_dvec3();
    sides.iter().any(|side| {
        let summed = side.truncate().abs().dot(reach) + side.w.abs();
        farthest_inside(bounds, side) < -summed * view_box::ROUNDING
    })
}

/// Returns the greatest product of a plane with a point of a box.
fn farthest_inside(bounds: &Aabb, side: &DVec4) -> f64 {
    let centre: DVec3 = (bounds.min.as_dvec3() + bounds.max.as_dvec3()) * 0.5;
    let half: DVec3 = (bounds.max.as_dvec3() - bounds.min.as_dvec3()) * 0.5;
    let normal = side.truncate();
    normal.dot(centre) + side.w + normal.abs().dot(half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        light_space,
        scene::{Instance, Mesh, Scene},
    };
    use glam::{Affine3A, Mat4, Vec3};

    /// Returns a small triangle at a point.
    fn triangle(at: Vec3) -> [Vec3; 3] {
        [at, at + Vec3::X * 0.1, at + Vec3::Y * 0.1]
    }

    /// Returns 64 triangles, which are one run, at each of these positions.
    fn geometry(places: &[Vec3]) -> Geometry {
        let positions: Vec<Vec3> = places
            .iter()
            .flat_map(|&at| std::iter::repeat_n(triangle(at), 64).flatten())
            .collect();
        let triangles = (0..positions.len() as u32 / 3)
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect();
        let scene = Scene {
            meshes: vec![Mesh::new("triangles", positions, triangles).expect("valid")],
            instances: vec![Instance::new(0, Affine3A::IDENTITY)],
            ..Scene::default()
        };
        Geometry::bake(&scene).expect("valid")
    }

    /// Returns a light space that looks along -z from the origin, 90 degrees wide.
    fn space() -> LightSpace {
        LightSpace {
            view_from_world: Mat4::IDENTITY,
            clip_from_view: light_space::perspective(std::f32::consts::FRAC_PI_2, 1.0, 0.1, 100.0)
                .expect("valid"),
        }
    }

    #[test]
    fn what_lies_next_to_or_behind_is_left_out() {
        let before = Vec3::new(0.0, 0.0, -5.0);
        let adjacent = Vec3::new(20.0, 0.0, -5.0);
        let behind = Vec3::new(0.0, 0.0, 5.0);
        let at_the_rim = Vec3::new(5.05, 0.0, -5.0);
        let set = CasterSet::shown_in(
            &geometry(&[before, adjacent, behind, at_the_rim, adjacent]),
            &space(),
            64,
        );
        assert_eq!(set, CasterSet::Runs([0..64, 192..256].into()));
        assert!(CasterSet::shown_in(&geometry(&[behind]), &space(), 64).is_empty());
        let all = CasterSet::shown_in(&geometry(&[before, before]), &space(), 64);
        assert_eq!(all, CasterSet::All);
    }

    #[test]
    fn small_gaps_are_drawn_too() {
        let before = Vec3::new(0.0, 0.0, -5.0);
        let behind = Vec3::new(0.0, 0.0, 5.0);
        let mut places = vec![before; 70];
        places[7] = behind;
        let set = CasterSet::shown_in(&geometry(&places), &space(), 64);
        assert_eq!(set, CasterSet::All, "a gap of 64 triangles of 4480");
    }
}
