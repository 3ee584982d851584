//! A map's texels as they lie on receivers: what a perfect map would answer, and how far edges are in texels.
//!
//! A receiver is seen through the texel that it falls on. A *perfect map* holds, at each texel's centre, the exact
//! answer for the receiver's own plane; it has no acne, no gap and no leak, and yet edges run along its texels. Its error
//! is what edge aliasing alone must cause at that size, and so the yardstick for all that are limited by it.

use glam::{DMat4, DVec2, DVec3, Vec3};
use umbrage_core::{Geometry, Invalid, Light, LightSpaces, Receivers, light_sample};
use umbrage_plan::truth::{Point, Seen, TruthOptions, trace_points};

/// Light spaces with their inverses, and the maps' side in texels.
#[derive(Clone, Debug)]
pub struct Texels {
    spaces: Vec<[DMat4; 2]>,
    size: f64,
}

/// Planes that the light meets at a smaller sine than this have no footprint worth the name.
const GRAZING: f64 = 1e-6;

impl Texels {
    /// Texels of maps of `size` texels a side that lie so.
    pub fn new(spaces: &LightSpaces, size: u32) -> Self {
        let pair = |space: &umbrage_core::LightSpace| {
            let clip_from_world =
                space.clip_from_view.as_dmat4() * space.view_from_world.as_dmat4();
            [clip_from_world, clip_from_world.inverse()]
        };
        Self {
            spaces: spaces.spaces.iter().map(pair).collect(),
            size: f64::from(size),
        }
    }

    /// The point of the plane through `p` with normal `n` that is seen where `to` takes p's place on the map, texels from
    /// the top left. None where no map shows p, or its plane is seen edge-on.
    pub fn moved(&self, p: Vec3, n: Vec3, to: impl Fn(DVec2) -> DVec2) -> Option<Vec3> {
        let (p, n) = (p.as_dvec3(), n.as_dvec3());
        let on_map = |[clip_from_world, _]: &&[DMat4; 2]| {
            let q = *clip_from_world * p.extend(1.0);
            q.w > 0.0 && q.x.abs() <= q.w && q.y.abs() <= q.w
        };
        let [clip_from_world, world_from_clip] = self.spaces.iter().find(on_map)?;
        let ndc = clip_from_world.project_point3(p);
        let texel = to(DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * self.size) / self.size;
        let at = |z: f64| {
            world_from_clip.project_point3(DVec3::new(2.0 * texel.x - 1.0, 1.0 - 2.0 * texel.y, z))
        };
        let (near, far) = (at(0.0), at(1.0));
        let along = far - near;
        let slope = n.dot(along);
        let t = n.dot(p - near) / slope;
        let q = near + along * t;
        (slope.abs() > GRAZING * along.length() && q.is_finite()).then_some(q.as_vec3())
    }

    /// Traced visibility at every receiver, its place on the map taken elsewhere by `to`, and where that is by `keep` (of
    /// the receiver's index). None where no map shows it.
    ///
    /// # Errors
    /// When the light is not valid.
    pub fn seen(
        &self,
        geometry: &Geometry,
        light: &Light,
        receivers: &Receivers,
        options: &TruthOptions,
        to: impl Fn(DVec2) -> DVec2,
        keep: impl Fn(usize, Vec3) -> Vec3,
    ) -> Result<Vec<Option<(Vec3, Seen)>>, Invalid> {
        let place = |i: usize| {
            let moved = || self.moved(receivers.position(i), receivers.normal(i), &to);
            Some((i, keep(i, receivers.receives[i].then(moved)??)))
        };
        let places: Vec<(usize, Vec3)> = (0..receivers.len()).filter_map(place).collect();
        let any = Point::new(Vec3::ZERO, Vec3::Y, geometry);
        let point = |&(i, p): &(usize, Vec3)| point_at(&any, receivers, i, p);
        let points: Vec<Point> = places.iter().map(point).collect();
        let mut out = vec![None; receivers.len()];
        for ((i, p), seen) in places
            .into_iter()
            .zip(trace_points(geometry, light, &points, options)?)
        {
            out[i] = Some((p, seen));
        }
        Ok(out)
    }
}

/// A receiver's point, elsewhere on its plane; `any` is any point of the geometry.
pub(super) fn point_at(any: &Point, receivers: &Receivers, i: usize, position: Vec3) -> Point {
    let (x, y) = (i as u32 % receivers.size.x, i as u32 / receivers.size.x);
    let (triangle, normal) = (receivers.triangle[i], receivers.normal(i));
    Point {
        position,
        normal,
        triangle,
        seed: light_sample::seed(x, y),
        ..*any
    }
}

/// As far along the way from `p` to `q`, both on a triangle's plane, as the triangle reaches; p where it is outside itself.
pub(super) fn within(p: Vec3, q: Vec3, [a, b, c]: [Vec3; 3]) -> Vec3 {
    let n = (b - a).cross(c - a);
    let edges = [(a, b), (b, c), (c, a)].map(|(a, b)| {
        let inward = n.cross(b - a);
        [inward.dot(p - a), inward.dot(q - a)]
    });
    let part = |[at_p, at_q]: [f32; 2]| {
        if at_q >= 0.0 {
            1.0
        } else {
            (at_p / (at_p - at_q)).max(0.0)
        }
    };
    p + (q - p) * edges.map(part).into_iter().fold(1.0, f32::min)
}

/// To the middle of the texel: what a perfect map does.
pub fn to_center(texel: DVec2) -> DVec2 {
    texel.floor() + 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::{LightSpace, glam::Mat4, light_space};

    /// A map of 10 texels that looks straight down on 10 x 10 m.
    fn texels() -> Texels {
        let view_from_world =
            light_space::look_along(Vec3::Y * 5.0, Vec3::NEG_Y, Vec3::NEG_Z).expect("valid");
        let extents = light_space::Extents {
            left: -5.0,
            right: 5.0,
            bottom: -5.0,
            top: 5.0,
            near: 0.0,
            far: 10.0,
        };
        let clip_from_view: Mat4 = light_space::orthographic(extents).expect("valid");
        let space = LightSpace {
            view_from_world,
            clip_from_view,
        };
        let spaces = LightSpaces::with_all_casters(vec![space]);
        Texels::new(&spaces, 10)
    }

    #[test]
    fn places_snap_to_texel_centres_along_the_receivers_plane() {
        let t = texels();
        let flat = t
            .moved(Vec3::new(0.2, 1.0, 3.9), Vec3::Y, to_center)
            .expect("on the map");
        assert!(flat.distance(Vec3::new(0.5, 1.0, 3.5)) < 1e-5, "{flat}");
        // A plane that rises by one along x: moving .3 m in x raises the point by as much.
        let n = Vec3::new(-1.0, 1.0, 0.0).normalize();
        let sloped = t
            .moved(Vec3::new(0.2, 1.0, 3.5), n, to_center)
            .expect("on the map");
        assert!(sloped.distance(Vec3::new(0.5, 1.3, 3.5)) < 1e-5, "{sloped}");
    }

    #[test]
    fn ways_end_at_the_triangles_edge() {
        let triangle = [Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0];
        let p = Vec3::new(1.0, 0.0, 1.0);
        for (q, expected) in [
            (Vec3::new(2.0, 0.0, 1.0), Vec3::new(2.0, 0.0, 1.0)),
            (Vec3::new(-1.0, 0.0, 1.0), Vec3::new(0.0, 0.0, 1.0)),
            (Vec3::new(5.0, 0.0, 5.0), Vec3::new(2.0, 0.0, 2.0)),
        ] {
            assert!(within(p, q, triangle).distance(expected) < 1e-6, "{q}");
        }
        assert_eq!(within(-p, p * -2.0, triangle), -p);
    }

    #[test]
    fn beside_the_map_and_edge_on_there_is_no_answer() {
        assert_eq!(
            texels().moved(Vec3::new(5.2, 0.0, 0.0), Vec3::Y, to_center),
            None
        );
        assert_eq!(texels().moved(Vec3::ZERO, Vec3::X, to_center), None);
    }
}
