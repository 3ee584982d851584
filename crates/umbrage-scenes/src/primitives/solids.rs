//! Flat-sided shapes.

use super::bare;
use umbrage_core::Mesh;
use umbrage_core::glam::{Vec2, Vec3};

/// A rectangle around height 0 that faces up, open at its rim: `half` is half its size in x and z,
/// `cells` the number of quads along each. The texture covers it once, u along x and v along z.
pub(crate) fn grid(half: [f32; 2], cells: [u32; 2], height: impl Fn(f32, f32) -> f32) -> Mesh {
    grid_with(half, cells, &height)
}

/// [`grid`] with a dynamic height function, which is compiled once.
fn grid_with(half: [f32; 2], cells: [u32; 2], height: &dyn Fn(f32, f32) -> f32) -> Mesh {
    let [nx, nz] = cells;
    let at = |i: u32, n: u32, half: f32| half * (2.0 * i as f32 / n as f32 - 1.0);
    let mut positions = Vec::with_capacity((nx as usize + 1) * (nz as usize + 1));
    for k in 0..=nz {
        positions.extend((0..=nx).map(|i| {
            let x = at(i, nx, half[0]);
            let z = at(k, nz, half[1]);
            Vec3::new(x, height(x, z), z)
        }));
    }
    let uvs = (0..=nz)
        .flat_map(|k| (0..=nx).map(move |i| Vec2::new(i as f32 / nx as f32, k as f32 / nz as f32)));
    let corner = |i: u32, k: u32| k * (nx + 1) + i;
    let triangles = (0..nz).flat_map(|k| {
        (0..nx).flat_map(move |i| {
            let a = corner(i, k);
            let b = corner(i, k + 1);
            let c = corner(i + 1, k + 1);
            let d = corner(i + 1, k);
            [[a, b, c], [a, c, d]]
        })
    });
    Mesh {
        uvs: uvs.collect(),
        ..bare("grid", positions, triangles.collect())
    }
}

/// One open quad from its corners in order. They are counter-clockwise on its front, and the first
/// is the texture's bottom left.
pub(crate) fn quad(corners: [Vec3; 4]) -> Mesh {
    let uvs = [Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO].to_vec();
    Mesh {
        uvs,
        ..bare("quad", corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
    }
}

/// Returns the mesh with its texture repeated `times` along u and v.
pub(crate) fn tile_mesh(mesh: Mesh, times: Vec2) -> Mesh {
    Mesh {
        uvs: mesh.uvs.iter().map(|uv| *uv * times).collect(),
        ..mesh
    }
}

/// A box whose faces point inwards.
pub(crate) fn room(min: Vec3, max: Vec3) -> Mesh {
    let mut mesh = Mesh {
        name: "room".to_owned(),
        ..block(min, max)
    };
    mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    mesh.normals.iter_mut().for_each(|n| *n = -*n);
    mesh.uvs.iter_mut().for_each(|uv| uv.x = 1.0 - uv.x);
    mesh
}

/// Six closed slabs, `wall` thick, around an empty box: floor, ceiling, then the walls at -x, +x,
/// -z, +z.
pub(crate) fn slabs_around(min: Vec3, max: Vec3, wall: f32) -> [Mesh; 6] {
    let low = min - wall;
    let high = max + wall;
    let at = Vec3::new;
    [
        (low, at(high.x, min.y, high.z)),
        (at(low.x, max.y, low.z), high),
        (at(low.x, min.y, low.z), at(min.x, max.y, high.z)),
        (at(max.x, min.y, low.z), at(high.x, max.y, high.z)),
        (at(min.x, min.y, low.z), at(max.x, max.y, min.z)),
        (at(min.x, min.y, max.z), at(max.x, max.y, high.z)),
    ]
    .map(|(min, max)| block(min, max))
}

/// Returns the texture position of a box's corner (0 or 1 along each axis) on the side with this
/// `normal`: upright on walls, and seen from above on the floor, with -z at the top.
fn side_uv(corner: Vec3, normal: Vec3) -> Vec2 {
    let up = if normal.y == 0.0 {
        Vec3::Y
    } else {
        Vec3::NEG_Z
    };
    let p = corner - 0.5;
    Vec2::new(0.5 + p.dot(up.cross(normal)), 0.5 - p.dot(up))
}

/// A box with flat shading normals and four vertices a side. The texture covers each side once.
pub(crate) fn block(min: impl Into<Vec3>, max: impl Into<Vec3>) -> Mesh {
    let (min, max) = (min.into(), max.into());
    let mut mesh = bare("box", Vec::new(), Vec::new());
    for axis in 0..3 {
        for sign in [-1.0_f32, 1.0] {
            let u = (axis + 1) % 3;
            let v = (axis + 2) % 3;
            let base = mesh.positions.len() as u32;
            for (s, t) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                let mut p = if sign > 0.0 { max } else { min };
                p[u] = [min, max][s][u];
                p[v] = [min, max][t][v];
                let normal = Vec3::AXES[axis] * sign;
                let mut corner = normal.max(Vec3::ZERO);
                (corner[u], corner[v]) = (s as f32, t as f32);
                mesh.positions.push(p);
                mesh.normals.push(normal);
                mesh.uvs.push(side_uv(corner, normal));
            }
            let sides = if sign > 0.0 {
                [[0, 1, 2], [0, 2, 3]]
            } else {
                [[0, 2, 1], [0, 3, 2]]
            };
            mesh.triangles.extend(sides.map(|t| t.map(|v| v + base)));
        }
    }
    mesh
}
