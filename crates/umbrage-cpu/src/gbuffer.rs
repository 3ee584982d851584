//! Receivers: triangle ids are rasterised from the camera, then each pixel's ray meets its triangle's plane.

use crate::raster::{Draw, Mode, Rasterizer, Target};
use rayon::prelude::*;
use umbrage_core::{
    Camera, Cull, Geometry, Invalid, NO_TRIANGLE, RasterBias, Receivers, Simd,
    glam::{UVec2, Vec3},
    math::dot3,
    resolve::{at_pixel, resolve},
};

/// What a valid camera sees.
pub(crate) fn find(
    rasterizer: &mut Rasterizer,
    simd: Simd,
    camera: &Camera,
    geometry: &Geometry,
) -> Receivers {
    let mut found = Receivers::empty(camera.size);
    let draw = Draw {
        positions: geometry.positions(),
        triangles: geometry.triangles(),
        first_id: 0,
        clip_from_world: camera.space().clip_from_world(),
        size: camera.size,
        cull: Cull::None,
        bias: RasterBias::default(),
        mode: Mode::DepthWithIds,
        simd,
    };
    let width = camera.size.x as usize;
    let texels = &mut found.depth;
    let ids = &mut found.triangle;
    rasterizer.draw(
        &draw,
        Target {
            width,
            texels,
            ids,
            other: &[],
            clear: true,
        },
    );
    resolve_all(&mut found, camera, geometry);
    found
}

/// One row of all that is found out about receivers.
struct Row<'a> {
    position: [&'a mut [f32]; 3],
    normal: [&'a mut [f32]; 3],
    depth: &'a mut [f32],
    distance: &'a mut [f32],
    triangle: &'a mut [u32],
    receives: &'a mut [bool],
}

fn resolve_all(r: &mut Receivers, camera: &Camera, geometry: &Geometry) {
    let width = camera.size.x as usize;
    let rays = camera.rays();
    let receivers = geometry.receivers();
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
    (positions, normals, others)
        .into_par_iter()
        .enumerate()
        .for_each(|(y, (p, n, o))| {
            let row = Row {
                position: [p.0, p.1, p.2],
                normal: [n.0, n.1, n.2],
                depth: o.0,
                distance: o.1,
                triangle: o.2,
                receives: o.3,
            };
            row.resolve(y as u32, &rays, geometry, &receivers);
        });
}

impl Row<'_> {
    fn resolve(
        mut self,
        y: u32,
        rays: &umbrage_core::CameraRays,
        geometry: &Geometry,
        receivers: &std::ops::Range<u32>,
    ) {
        for x in 0..self.triangle.len() {
            let id = self.triangle[x];
            if id == NO_TRIANGLE {
                continue;
            }
            let Some(found) = resolve(rays, x as u32, y, geometry.corners(id)) else {
                (self.triangle[x], self.depth[x]) = (NO_TRIANGLE, 1.0);
                continue;
            };
            let d = at_pixel(rays.dir, rays.dir_dx, rays.dir_dy, x as u32, y);
            self.distance[x] = found.t * dot3(d, d).sqrt();
            self.receives[x] = receivers.contains(&id);
            for (k, (p, n)) in self.position.iter_mut().zip(&mut self.normal).enumerate() {
                (p[x], n[x]) = (found.position[k], found.normal[k]);
            }
        }
    }
}

/// Adds shading normals.
pub(crate) fn shade(r: &mut Receivers, camera: &Camera, geometry: &Geometry) {
    let width = r.size.x as usize;
    let rays = camera.rays();
    let mut normals = vec![Vec3::ZERO; r.len()];
    normals
        .par_iter_mut()
        .enumerate()
        .filter(|(i, _)| r.triangle[*i] != NO_TRIANGLE)
        .for_each(|(i, out)| {
            let d = at_pixel(
                rays.dir,
                rays.dir_dx,
                rays.dir_dy,
                (i % width) as u32,
                (i / width) as u32,
            );
            let shaded =
                shading_normal(geometry, r.triangle[i], r.position(i)).normalize_or(r.normal(i));
            *out = if shaded.dot(d) > 0.0 { -shaded } else { shaded };
        });
    r.shading_normals = normals;
}

/// The vertices' normals, weighted with the barycentric coordinates of a point of the triangle.
fn shading_normal(geometry: &Geometry, triangle: u32, p: Vec3) -> Vec3 {
    let [a, b, c] = geometry.corners(triangle);
    let n = (b - a).cross(c - a);
    let weight = |q: Vec3, r: Vec3| n.dot((q - p).cross(r - p));
    let weights = [weight(b, c), weight(c, a), weight(a, b)];
    let corners = geometry.triangles()[triangle as usize];
    corners
        .iter()
        .zip(weights)
        .map(|(&v, w)| geometry.normals()[v as usize] * w)
        .sum::<Vec3>()
        / n.length_squared()
}

/// Objects to receivers that don't belong to an image of this size.
pub(crate) fn check(r: &Receivers, size: UVec2) -> Result<(), Invalid> {
    if r.size != size {
        let why = format!(
            "are {} x {} pixels, but the camera's image is {} x {}",
            r.size.x, r.size.y, size.x, size.y
        );
        return Err(Invalid::new(
            "receivers",
            why,
            "make them with the same camera",
        ));
    }
    r.validate()
}

/// Bytes of all arrays.
pub(crate) fn bytes(r: &Receivers) -> u64 {
    let floats = [&r.x, &r.y, &r.z, &r.nx, &r.ny, &r.nz, &r.depth, &r.distance];
    let words = floats.iter().map(|v| v.len()).sum::<usize>() + r.triangle.len();
    (4 * words + size_of::<Vec3>() * r.shading_normals.len() + r.receives.len()) as u64
}
