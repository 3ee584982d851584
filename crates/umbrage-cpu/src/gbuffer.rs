//! Receivers of a camera. Triangle ids are rasterised first; then each pixel's ray is intersected
//! with its triangle's plane.

use crate::raster::{Draw, Holes, Mode, Rasterizer, Target};
use rayon::prelude::*;
use umbrage_core::{
    Camera, Cull, Geometry, Invalid, NO_TRIANGLE, RasterBias, Receivers, Simd,
    glam::{UVec2, Vec3},
    math::dot3,
    resolve::{at_pixel, resolve},
};

/// Returns the receivers visible to a valid camera.
pub(crate) fn find(
    rasterizer: &mut Rasterizer,
    simd: Simd,
    camera: &Camera,
    geometry: &Geometry,
) -> Receivers {
    let mut found = Receivers::empty(camera.size);
    let rays = camera.rays();
    // Separate opaque from alpha-tested triangles.
    let everything = 0..geometry.triangles().len() as u32;
    let mut parts = vec![(everything.clone(), None)];
    if let Some(cut_outs) = geometry.cut_outs() {
        let holes = Holes {
            cut_outs,
            geometry,
            rays: &rays,
        };
        let [whole, cut_out] = cut_outs.split(&[everything]);
        parts = whole.into_iter().map(|run| (run, None)).collect();
        parts.extend(cut_out.into_iter().map(|run| (run, Some(holes))));
    }
    // Rasterise depth and ids.
    let mut is_first = true;
    for (run, holes) in parts {
        let draw = Draw {
            positions: geometry.positions(),
            triangles: geometry.run(&run),
            first_id: run.start,
            clip_from_world: camera.space().clip_from_world(),
            size: camera.size,
            cull: Cull::None,
            bias: RasterBias::default(),
            mode: Mode::DepthWithIds,
            simd,
            holes,
        };
        let target = Target {
            width: camera.size.x as usize,
            texels: &mut found.depth,
            ids: &mut found.triangle,
            other: &[],
            clear: is_first,
        };
        rasterizer.draw(&draw, target);
        is_first = false;
    }
    resolve_all(&mut found, camera, geometry);
    found
}

/// Mutable row of [`Receivers`].
struct PixelRow<'a> {
    x: &'a mut [f32],
    y: &'a mut [f32],
    z: &'a mut [f32],
    nx: &'a mut [f32],
    ny: &'a mut [f32],
    nz: &'a mut [f32],
    depth: &'a mut [f32],
    distance: &'a mut [f32],
    triangle: &'a mut [u32],
    receives: &'a mut [bool],
}

/// Fills the fields that depend on triangle ids, row by row.
fn resolve_all(r: &mut Receivers, camera: &Camera, geometry: &Geometry) {
    let width = camera.size.x as usize;
    let rays = camera.rays();
    let receivers = geometry.receivers();
    // Nest the tuples, since there are no parallel iterators over tuples of this size.
    let positions = (
        r.x.par_chunks_mut(width),
        r.y.par_chunks_mut(width),
        r.z.par_chunks_mut(width),
    );
    let normals = (
        r.nx.par_chunks_mut(width),
        r.ny.par_chunks_mut(width),
        r.nz.par_chunks_mut(width),
    );
    let others = (
        r.depth.par_chunks_mut(width),
        r.distance.par_chunks_mut(width),
        r.triangle.par_chunks_mut(width),
        r.receives.par_chunks_mut(width),
    );
    let rows = (positions, normals, others).into_par_iter().enumerate();
    rows.for_each(|(row_index, (position, normal, other))| {
        let row = PixelRow {
            x: position.0,
            y: position.1,
            z: position.2,
            nx: normal.0,
            ny: normal.1,
            nz: normal.2,
            depth: other.0,
            distance: other.1,
            triangle: other.2,
            receives: other.3,
        };
        row.resolve(row_index as u32, &rays, geometry, &receivers);
    });
}

impl PixelRow<'_> {
    fn resolve(
        self,
        row: u32,
        rays: &umbrage_core::CameraRays,
        geometry: &Geometry,
        receivers: &std::ops::Range<u32>,
    ) {
        for i in 0..self.triangle.len() {
            let id = self.triangle[i];
            if id == NO_TRIANGLE {
                continue;
            }
            let column = i as u32;
            let Some(found) = resolve(rays, column, row, geometry.corners(id)) else {
                // The ray is parallel to the triangle's plane.
                self.triangle[i] = NO_TRIANGLE;
                self.depth[i] = 1.0;
                continue;
            };
            let direction = at_pixel(rays.dir, rays.dir_dx, rays.dir_dy, column, row);
            self.distance[i] = found.t * dot3(direction, direction).sqrt();
            self.receives[i] = receivers.contains(&id);
            self.x[i] = found.position.x;
            self.y[i] = found.position.y;
            self.z[i] = found.position.z;
            self.nx[i] = found.normal.x;
            self.ny[i] = found.normal.y;
            self.nz[i] = found.normal.z;
        }
    }
}

/// Adds shading normals.
pub(crate) fn shade(r: &mut Receivers, camera: &Camera, geometry: &Geometry) {
    let width = r.size.x as usize;
    let rays = camera.rays();
    let mut normals = vec![Vec3::ZERO; r.len()];
    normals.par_iter_mut().enumerate().for_each(|(i, out)| {
        let triangle = r.triangle[i];
        if triangle == NO_TRIANGLE {
            return;
        }
        let column = (i % width) as u32;
        let row = (i / width) as u32;
        let direction = at_pixel(rays.dir, rays.dir_dx, rays.dir_dy, column, row);
        let normal = shading_normal(geometry, triangle, r.position(i)).normalize_or(r.normal(i));
        *out = if normal.dot(direction) > 0.0 {
            -normal
        } else {
            normal
        };
    });
    r.shading_normals = normals;
}

/// Returns the mean of a triangle's vertex normals, weighted by the barycentric coordinates of a
/// point `p` in it.
fn shading_normal(geometry: &Geometry, triangle: u32, p: Vec3) -> Vec3 {
    let [a, b, c] = geometry.corners(triangle);
    let n = (b - a).cross(c - a);
    // A corner's weight is the area of the triangle of `p` and the other two corners. All weights
    // share the factor |n|^2.
    let weight_a = n.dot((b - p).cross(c - p));
    let weight_b = n.dot((c - p).cross(a - p));
    let weight_c = n.dot((a - p).cross(b - p));
    let [normal_a, normal_b, normal_c] =
        geometry.triangles()[triangle as usize].map(|v| geometry.normals()[v as usize]);
    let sum = Vec3::ZERO + normal_a * weight_a + normal_b * weight_b + normal_c * weight_c;
    sum / n.length_squared()
}

/// Errors if the receivers are not valid or don't match the image size.
pub(crate) fn check(r: &Receivers, size: UVec2) -> Result<(), Invalid> {
    if r.size != size {
        let why = format!(
            "are {} x {} pixels, but the camera's image is {} x {}",
            r.size.x, r.size.y, size.x, size.y
        );
        return Err(Invalid::new(
            "receivers",
            why,
            "compute them with the same camera",
        ));
    }
    r.validate()
}

/// Returns the bytes of all arrays.
pub(crate) fn bytes(r: &Receivers) -> u64 {
    let floats = [&r.x, &r.y, &r.z, &r.nx, &r.ny, &r.nz, &r.depth, &r.distance];
    let words = floats.iter().map(|v| v.len()).sum::<usize>() + r.triangle.len();
    (4 * words + size_of::<Vec3>() * r.shading_normals.len() + r.receives.len()) as u64
}
