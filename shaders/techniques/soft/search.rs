//! CPU half of the kernel: neighbours traverse the hierarchy together, in vector lanes.
//!
//! The traversal skips nodes that project only to lattice points that are no longer open for any
//! neighbour. So it ends early behind large casters, and in a fine mesh it visits only triangles
//! that may hide a point.

use super::{
    SoftUniforms,
    footprint::{Footprint, Part},
    hidden::{ALL, Caster, LANES, Open, Seers, Shade, Words, close_below_horizon},
    holes::Leaf,
    lattice::{Lattice, Lattices, MAX_ROWS},
    light_plane::{LightPlane, is_lamp},
};
use umbrage_core::{
    Aabb, Bvh, CutOuts, NO_TRIANGLE, Simd, SimdTask, Span,
    bvh::{Shaft, ShaftSearch, Shafts},
    glam::{Vec3, Vec4},
    light_sample::{SHORT, ray_origin, seed},
};

/// Data of a search.
#[derive(Clone, Copy)]
pub(super) struct Search<'a> {
    pub(super) uniforms: &'a SoftUniforms,
    pub(super) lattices: &'a Lattices,
    pub(super) bvh: &'a Bvh,
    /// Alpha test of the casters; `None` if none is alpha-tested.
    pub(super) cut_outs: Option<&'a CutOuts>,
}

/// Fills `out`, which is as long as the span, with the light's visibility.
pub(super) fn look_up_span(simd: Simd, search: &Search<'_>, span: &Span<'_>, out: &mut [f32]) {
    let mut first = 0;
    while first < out.len() {
        // Process pixels that share a lattice together.
        let x = span.first.x as usize + first;
        let count = (LANES - x % LANES).min(out.len() - first);
        let group = Neighbours {
            search,
            span,
            first,
            out: &mut out[first..first + count],
        };
        if is_lamp(&search.uniforms.light) {
            simd.run_task(LookUp::<true>(group));
        } else {
            simd.run_task(LookUp::<false>(group));
        }
        first += count;
    }
}

/// Some receivers of a span, and the storage for their visibilities.
struct Neighbours<'a> {
    search: &'a Search<'a>,
    span: &'a Span<'a>,
    first: usize,
    out: &'a mut [f32],
}

/// Task that looks up neighbours; `LAMP`: the light has a position.
struct LookUp<'a, const LAMP: bool>(Neighbours<'a>);

impl<const LAMP: bool> SimdTask for LookUp<'_, LAMP> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Neighbours {
            search,
            span,
            first,
            out,
        } = self.0;
        let x = span.first.x + first as u32;
        let noise = seed(x / LANES as u32, span.first.y);
        let lattice = search.lattices.of_noise(noise);
        let mut walk = Walk::<LAMP>::begin(search, lattice, span, first, out.len());
        if let Some(shaft) = walk.shaft {
            search.bvh.in_shaft(&shaft, &mut walk);
        }
        for (lane, out) in out.iter_mut().enumerate() {
            let mut open = 0;
            for row in &walk.open[..walk.rows] {
                open += row[lane].count_ones();
            }
            *out = open as f32 / lattice.points as f32;
        }
    }
}

/// Traversal of the hierarchy for a group of neighbours.
struct Walk<'a, const LAMP: bool> {
    lattice: &'a Lattice,
    cut_outs: Option<&'a CutOuts>,
    rows: usize,
    seers: Seers,
    own: Words,
    open: Open,
    /// Points of each row that are open for any neighbour.
    open_to_any: [u32; MAX_ROWS],
    /// All bits for neighbours with an open point, else none.
    queried: Words,
    footprint: Footprint,
    /// Shade of the current triangle.
    shade: Shade,
    /// Shaft of all rays; `None` if nothing is open.
    shaft: Option<Shaft>,
    /// Shafts of the rays of each neighbour.
    shafts: Shafts,
}

impl<'a, const LAMP: bool> Walk<'a, LAMP> {
    /// Starts with `count` receivers of a span from `first` on. The part of the light below a
    /// receiver's own plane is hidden.
    #[inline(always)]
    fn begin(
        search: &Search<'a>,
        lattice: &'a Lattice,
        span: &Span<'_>,
        first: usize,
        count: usize,
    ) -> Self {
        let u = search.uniforms;
        let eye = u.eye.truncate();
        let rows = search.lattices.rows as usize;
        let mut seers = Seers::NONE;
        let mut own = [NO_TRIANGLE; LANES];
        let mut open: Open = [[0; LANES]; MAX_ROWS];
        let mut origins = [Vec3::ZERO; LANES];
        let mut planes = [LightPlane::NOWHERE; LANES];
        // Set up each receiver and its lattice points.
        for i in 0..count {
            let place = first + i;
            let p = span.position(place);
            let n = span.normal(place);
            let origin = ray_origin(p, n, eye, u.plane_reach);
            let plane = LightPlane::seen_from(&u.light, u.spread.w, origin);
            seers.set(i, origin, n, &plane);
            own[i] = span.triangle[place];
            for (open, &bits) in open[..rows].iter_mut().zip(&lattice.bits) {
                open[i] = bits;
            }
            origins[i] = origin;
            planes[i] = plane;
        }
        // Hide the points below the horizon.
        close_below_horizon(&seers, lattice, rows, &mut open);
        let mut out = Self {
            lattice,
            cut_outs: search.cut_outs,
            rows,
            seers,
            own,
            open,
            open_to_any: [0; MAX_ROWS],
            queried: [0; LANES],
            footprint: Footprint::NOTHING,
            shade: Shade::NONE,
            shaft: None,
            shafts: Shafts::all(&shaft_of::<LAMP>(u, &Aabb::from_points([origins[0]]))),
        };
        out.look_at_rows(0..rows);
        // Bound the receivers with open points.
        let mut start = Aabb::EMPTY;
        for (i, &origin) in origins.iter().enumerate() {
            if out.queried[i] != 0 {
                let at = Aabb::from_points([origin]);
                out.shafts.set(i, &shaft_of::<LAMP>(u, &at));
                start = start.union(&at);
            }
        }
        if start.is_empty() {
            return out;
        }
        // Project the light's points from the centre of these bounds.
        let middle = (start.min + start.max) * 0.5;
        let reach = (start.max - middle).max(middle - start.min);
        let plane = LightPlane::seen_from(&u.light, u.spread.w, middle);
        // Balls face each receiver, and the points of a light with a position are at a fraction of
        // the distance.
        let mut shift = if LAMP {
            reach.max_element() * (1.0 - SHORT)
        } else {
            0.0
        };
        for other in &planes[..count] {
            let turn = (other.u - plane.u).abs() + (other.v - plane.v).abs();
            shift = shift.max(2.0 * turn.max_element());
        }
        out.footprint =
            Footprint::new::<LAMP>(middle, reach, shift, &plane, search.lattices, lattice);
        out.shaft = Some(shaft_of::<LAMP>(u, &start));
        out
    }

    /// Updates the open points after some rows have changed.
    #[inline(always)]
    fn look_at_rows(&mut self, rows: std::ops::Range<usize>) {
        for row in rows {
            let open = &self.open[row];
            self.open_to_any[row] = open.iter().fold(0, |all, bits| all | bits);
        }
        let mut open_to = [0; LANES];
        for row in &self.open[..self.rows] {
            for (all, bits) in open_to.iter_mut().zip(row) {
                *all |= bits;
            }
        }
        self.queried = open_to.map(|bits| if bits == 0 { 0 } else { ALL });
    }

    #[inline(always)]
    fn is_open(&self, part: &Part) -> bool {
        let rows = &self.open_to_any[part.rows.clone()];
        rows.iter().any(|open| open & part.places != 0)
    }
}

impl<const LAMP: bool> ShaftSearch for Walk<'_, LAMP> {
    #[inline(always)]
    fn keep(&mut self, entered: u32, low: [Vec4; 3], high: [Vec4; 3]) -> u32 {
        let bounds = self.footprint.of_boxes(low, high);
        let mut rest = entered;
        let mut kept = 0;
        while rest != 0 {
            let which = rest.trailing_zeros();
            rest &= rest - 1;
            let part = self.footprint.part(&bounds, which as usize);
            let corner = |sides: &[Vec4; 3]| {
                let at = |axis: usize| sides[axis][which as usize];
                Vec3::new(at(0), at(1), at(2))
            };
            let entering = self
                .shafts
                .entered_boxes(corner(&low), corner(&high), &self.queried);
            if entering == [0; LANES] {
                continue;
            }
            kept |= u32::from(self.is_open(&part)) << which;
        }
        kept
    }

    #[inline(always)]
    fn visit(&mut self, id: u32, corners: [Vec3; 3]) -> bool {
        // Test the shafts of the receivers.
        let [a, b, c] = corners;
        let querying = self
            .shafts
            .entered_boxes(a.min(b).min(c), a.max(b).max(c), &self.queried);
        if querying == [0; LANES] {
            return false;
        }
        // Test the projection to the lattice for open points.
        let bounds = self.footprint.of_points(
            Vec4::new(a.x, b.x, c.x, a.x),
            Vec4::new(a.y, b.y, c.y, a.y),
            Vec4::new(a.z, b.z, c.z, a.z),
        );
        let part = self.footprint.part_of_three(&bounds);
        if !self.is_open(&part) {
            return false;
        }
        let caster = Caster::new(corners);
        // Receivers on the triangle ignore it.
        let mut querying = querying;
        for (querying, own) in querying.iter_mut().zip(self.own) {
            *querying = if own == id { 0 } else { *querying };
        }
        // Find the functions of the triangle.
        let step = self.lattice.step;
        if !(self.shade).find::<LAMP>(&caster, &self.seers, &querying, step) {
            return false;
        }
        // Hide the points of each row.
        if let Some(leaf) = Leaf::new(self.cut_outs, id, corners) {
            for row in part.rows.clone() {
                let open = &mut self.open[row];
                leaf.close::<LAMP>(&self.shade, &self.seers, self.lattice, row, open);
            }
        } else {
            for row in part.rows.clone() {
                self.shade
                    .close::<LAMP>(self.lattice.first_of(row), &mut self.open[row]);
            }
        }
        self.look_at_rows(part.rows);
        self.queried == [0; LANES]
    }
}

/// Returns the shaft of all rays from a box to the light.
#[inline(always)]
fn shaft_of<const LAMP: bool>(u: &SoftUniforms, start: &Aabb) -> Shaft {
    let center = u.light.center.truncate();
    let spread = u.spread.truncate();
    let [low, high] = [center - spread, center + spread];
    if LAMP {
        Shaft::between_boxes(
            start,
            &Aabb {
                min: low,
                max: high,
            },
        )
    } else {
        Shaft::along_direction(start, low * u.far, high * u.far)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::techniques::soft::Soft;
    use umbrage_core::{
        AlphaCutout, AlphaFilter, Camera, Geometry, Instance, Light, Material, Mesh, Scene,
        Texture, View,
        glam::{Affine3A, UVec2, Vec2},
        light_sample::hash,
    };

    /// Returns a deterministic number from -1 to 1.
    fn noise(state: &mut u32) -> f32 {
        *state = hash(*state);
        *state as f32 / 2_147_483_648.0 - 1.0
    }

    fn vector(state: &mut u32) -> Vec3 {
        Vec3::new(noise(state), noise(state), noise(state))
    }

    /// Returns a material with a texture that is about half transparent.
    fn leafy() -> (Material, Texture) {
        const SIDE: u32 = 9;
        let alpha = |i: u32| f32::from(u8::from(hash(i).is_multiple_of(2)));
        let texels = (0..SIDE * SIDE).map(|i| [1.0, 1.0, 1.0, alpha(i)]);
        let texture = Texture {
            name: "holes".into(),
            size: UVec2::splat(SIDE),
            texels: texels.collect(),
        };
        let material = Material {
            alpha: Some(AlphaCutout {
                texture: 0,
                cutoff: 0.5,
                filter: AlphaFilter::Nearest,
            }),
            ..Material::default()
        };
        (material, texture)
    }

    /// Returns triangles of all sizes in a ball, including thin ones and some with common corners.
    /// With `has_holes`, half of them are alpha-tested.
    fn soup(state: &mut u32, scale: f32, has_holes: bool) -> Geometry {
        let mut positions = Vec::new();
        for i in 0..400 {
            let at = vector(state) * scale;
            let size = scale * [0.3, 0.05, 0.005][i % 3];
            let side = vector(state) * size;
            let thin = if i % 4 == 0 { 0.02 } else { 1.0 };
            let last = positions.last().copied().unwrap_or(at);
            let first = if i % 5 == 0 { last } else { at };
            positions.extend([first, first + side, first + vector(state) * size * thin]);
        }
        let mut triangles: Vec<_> = (0..400).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let whole = triangles.split_off(if has_holes { 200 } else { 0 });
        let uvs = (0..1200).map(|i| Vec2::new((i % 3) as f32, (i % 7) as f32 * 0.4));
        let mesh = |triangles| {
            let mesh = Mesh::new("soup", positions.clone(), triangles).expect("valid");
            Mesh {
                uvs: uvs.clone().collect(),
                ..mesh
            }
        };
        let (material, texture) = leafy();
        let mut instances = vec![Instance::new(0, Affine3A::IDENTITY)];
        let mut meshes = vec![mesh(whole)];
        if has_holes {
            meshes.push(mesh(triangles));
            instances.push(Instance {
                material: Some(0),
                ..Instance::new(1, Affine3A::IDENTITY)
            });
        }
        let scene = Scene {
            meshes,
            instances,
            materials: vec![material],
            textures: vec![texture],
            ..Scene::default()
        };
        Geometry::bake(&scene).expect("valid")
    }

    fn lights(state: &mut u32, scale: f32) -> Vec<Light> {
        let place = vector(state).normalize() * 2.0 * scale;
        let inside = vector(state) * 0.5 * scale;
        let axis = vector(state);
        vec![
            Light::Directional {
                direction: axis,
                angular_diameter: 0.05,
            },
            Light::Directional {
                direction: axis,
                angular_diameter: 0.0,
            },
            Light::Point {
                position: place,
                radius: 0.2 * scale,
            },
            Light::Point {
                position: inside,
                radius: 0.05 * scale,
            },
            Light::Rect {
                center: place,
                half_u: axis.any_orthogonal_vector() * 0.2 * scale,
                half_v: axis.cross(axis.any_orthogonal_vector()) * 0.1 * scale,
            },
            Light::Disc {
                center: inside,
                normal: axis,
                radius: 0.3 * scale,
            },
        ]
    }

    /// Tests all casters in sequence, with every row of each, without hierarchy, shaft or
    /// footprint.
    fn one_by_one<const LAMP: bool>(geometry: &Geometry, walk: &Walk<'_, LAMP>, open: &mut Open) {
        let mut shade = Shade::NONE;
        for id in geometry.casters() {
            let querying = walk.own.map(|own| if own == id { 0 } else { ALL });
            let caster = Caster::new(geometry.corners(id));
            let step = walk.lattice.step;
            if !shade.find::<LAMP>(&caster, &walk.seers, &querying, step) {
                continue;
            }
            let leaf = Leaf::new(walk.cut_outs, id, geometry.corners(id));
            for (row, open) in open[..walk.rows].iter_mut().enumerate() {
                match leaf {
                    Some(leaf) => leaf.close::<LAMP>(&shade, &walk.seers, walk.lattice, row, open),
                    None => shade.close::<LAMP>(walk.lattice.first_of(row), open),
                }
            }
        }
    }

    /// Result of a comparison.
    #[derive(Default)]
    struct LookupCounts {
        /// Number of hidden points.
        hidden: u32,
        /// Number of points tested by rays, and of those where rays differ.
        queried: u32,
        unlike: u32,
    }

    impl LookupCounts {
        fn add(&mut self, other: &Self) {
            self.hidden += other.hidden;
            self.queried += other.queried;
            self.unlike += other.unlike;
        }
    }

    /// Tests rays to all points that were open for the first receiver before.
    fn query_rays<const LAMP: bool>(
        search: &Search<'_>,
        walk: &Walk<'_, LAMP>,
        before: &Open,
    ) -> LookupCounts {
        const LANE: usize = 0;
        let mut out = LookupCounts::default();
        for (row, open) in before[..walk.rows].iter().enumerate() {
            let places = (0..MAX_ROWS as u32).filter(|place| open[LANE] >> place & 1 == 1);
            for place in places {
                let point = walk.lattice.first_of(row) + walk.lattice.step * place as f32;
                let [o, d] = walk.seers.ray(LANE, point);
                let d = if LAMP { d } else { d * search.uniforms.far };
                let is_lit = !search.bvh.is_occluded(o, d, walk.own[LANE]);
                let is_open = walk.open[row][LANE] >> place & 1 == 1;
                out.queried += 1;
                out.unlike += u32::from(is_lit != is_open);
            }
        }
        out
    }

    /// Compares the traversal of eight random receivers with all casters in sequence, and with
    /// rays.
    fn compare<const LAMP: bool>(
        state: &mut u32,
        search: &Search<'_>,
        geometry: &Geometry,
    ) -> LookupCounts {
        let scale = geometry.bounds().diagonal() * 0.3;
        // Place them close together, like neighbours, or far apart, as across an edge.
        let spread = scale * [0.01, 0.1, 1.0][*state as usize % 3];
        let middle = vector(state) * scale;
        let normal = vector(state).normalize();
        let mut values: [Vec<f32>; 6] = Default::default();
        for _ in 0..LANES {
            let p = middle + vector(state) * spread;
            let n = (normal + vector(state) * 0.1).normalize();
            for (values, value) in values.iter_mut().zip([p.x, p.y, p.z, n.x, n.y, n.z]) {
                values.push(value);
            }
        }
        let [x, y, z, nx, ny, nz] = &values;
        let triangle: Vec<u32> = (0..LANES as u32).map(|i| i * 7 % 400).collect();
        let span = Span {
            first: UVec2::new(8, 3),
            x,
            y,
            z,
            nx,
            ny,
            nz,
            triangle: &triangle,
        };
        let lattice = search.lattices.of_noise(*state);
        let mut walk = Walk::<LAMP>::begin(search, lattice, &span, 0, LANES);
        let before = walk.open;
        let mut expected = before;
        one_by_one(geometry, &walk, &mut expected);
        if let Some(shaft) = walk.shaft {
            search.bvh.in_shaft(&shaft, &mut walk);
        }
        let count = |open: &Open| -> u32 { open.iter().flatten().map(|b| b.count_ones()).sum() };
        // A traversal that ends early must have no open points.
        assert_eq!(walk.open, expected, "{LAMP}, spread {spread}");
        let hidden = count(&before) - count(&expected);
        LookupCounts {
            hidden,
            ..query_rays(search, &walk, &before)
        }
    }

    /// Compares many traversals of random triangles.
    fn compare_all(has_holes: bool) -> LookupCounts {
        let mut state = 3;
        let mut all = LookupCounts::default();
        for round in 0..60 {
            let scale = [1.0, 1e-3, 1e4][round % 3];
            let geometry = soup(&mut state, scale, has_holes);
            for light in lights(&mut state, scale) {
                let error = [0.05, 0.01, 0.002][round / 3 % 3];
                let near_far = [scale, 10.0 * scale];
                let eye = Vec3::splat(2.0 * scale);
                let camera =
                    Camera::perspective(eye, Vec3::ZERO, Vec3::Y, 1.0, near_far, UVec2::ONE)
                        .expect("valid");
                let view = View::new(&camera, &light, &geometry);
                let kernel = Soft { error }.kernel(&view, &geometry);
                let search = kernel.search();
                for _ in 0..20 {
                    let compared = if is_lamp(&kernel.uniforms.light) {
                        compare::<true>(&mut state, &search, &geometry)
                    } else {
                        compare::<false>(&mut state, &search, &geometry)
                    };
                    all.add(&compared);
                }
            }
        }
        all
    }

    /// Traversals equal the test of all casters in sequence. They equal rays except at the edges of
    /// triangles, where either result may be right.
    #[test]
    fn walks_leave_nothing_out() {
        for has_holes in [false, true] {
            let LookupCounts {
                hidden,
                queried: requested,
                unlike,
            } = compare_all(has_holes);
            assert!(hidden > 100_000, "too few hidden points: {hidden}");
            assert!(
                unlike <= requested / 10_000,
                "alpha-tested: {has_holes}: rays differ at {unlike} of {requested} points"
            );
        }
    }
}
