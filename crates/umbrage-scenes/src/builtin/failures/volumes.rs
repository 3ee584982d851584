//! Difficult cases of shadow volumes: the position of the eye, the topology of meshes, the number
//! of casters.

use super::SMALL;
use crate::{
    builtin::{noise::uniform, speed},
    framing::Shot,
    primitives::{block, grid, icosphere, pillar, quad},
    stage::{Stage, bulb, sun},
};
use umbrage_core::glam::{Affine3A, IVec3, Quat, UVec2, Vec3};
use umbrage_core::{Light, Mesh, Scene};

/// Distance from the eye to the near plane, metres.
const NEAR: f32 = 0.1;
/// Distance from the eye to the side of the umbra, on its right.
const MARGIN: f32 = 0.03;
const EYE: Vec3 = Vec3::new(0.0, 1.2, 4.0);
/// Heights of the slab's underside and top. The edge of the top bounds the shadow.
const SLAB_HEIGHTS: [f32; 2] = [3.0, 3.15];
/// Vector from the slab's edge to the light, and to the sun.
const TO_LIGHT: Vec3 = Vec3::new(-1.5, 3.0, -0.4);

/// The eye is in the shadow of a slab overhead. The side of that shadow is 3 cm away and cuts the
/// near plane. The shadow of a post behind the eye, out of the image on the left, cuts the near
/// plane, too. Volume counts are wrong all over the image if they start at the eye, or lose what
/// the near plane clips.
fn under_slab(name: &str, light: Light) -> Scene {
    let shot = Shot {
        eye: EYE,
        target: Vec3::new(0.2, 0.75, 0.0),
        up: Vec3::Y,
        fov_y: 56.0_f32.to_radians(),
        size: UVec2::from(SMALL),
    };
    let post = Affine3A::from_translation(EYE.with_y(0.0) + Vec3::new(-0.1, 0.0, 0.02));
    Stage::new(name)
        .put(grid([6.0, 6.0], [1, 1], |_, _| 0.0))
        .put(block(
            [-4.0, SLAB_HEIGHTS[0], -1.5],
            [slab_edge(), SLAB_HEIGHTS[1], 5.5],
        ))
        .put_many(pillar(0.03, 2.0, 12), [post])
        .put_many(
            pillar(0.12, 1.9, 24),
            [
                Affine3A::from_translation(Vec3::new(-0.7, 0.0, 0.3)),
                Affine3A::from_translation(Vec3::new(1.3, 0.0, 0.6)),
            ],
        )
        .put(icosphere([0.5, 0.6, 1.6], 0.22, 3))
        .light(light)
        .shoot_from(&shot, Some(NEAR))
}

/// Returns the x of the slab's edge. The plane through its upper edge and the light passes
/// [`MARGIN`] to the right of the eye.
fn slab_edge() -> f32 {
    EYE.x + MARGIN + TO_LIGHT.x / TO_LIGHT.y * (SLAB_HEIGHTS[1] - EYE.y)
}

pub(crate) fn eye_in_umbra() -> Scene {
    under_slab("eye-in-umbra", sun(-TO_LIGHT.x, -TO_LIGHT.y, -TO_LIGHT.z))
}

pub(crate) fn eye_in_umbra_lamp() -> Scene {
    let [x, y, z] = (Vec3::new(slab_edge(), SLAB_HEIGHTS[1], EYE.z - 1.0) + TO_LIGHT).to_array();
    under_slab("eye-in-umbra-lamp", bulb(x, y, z))
}

/// Casters whose edges don't pair up: each face listed twice; a corner in the middle of a
/// neighbour's edge; a lid without one of its triangles; a fin, so that three faces share an edge;
/// two boxes with a common edge, so that four do; a side with reversed winding.
fn broken_scene(name: &str, light: Light) -> Scene {
    let intact = block([-0.35, 0.0, -0.35], [0.35, 0.8, 0.35]);
    // Casters with their position on the floor, x and z.
    let casters = [
        (double_mesh(intact.clone()), -2.0_f32, -0.9),
        (with_t_junction(intact.clone()), 0.0, -1.1),
        (mesh_with_hole(intact.clone()), 2.0, -0.9),
        (add_fin(intact.clone()), -1.9, 0.9),
        (touching_mesh(), 0.0, 0.8),
        (flip_triangle(intact), 1.9, 0.9),
    ];
    let mut stage = Stage::new(name).put(grid([4.5, 4.0], [1, 1], |_, _| 0.0));
    for (mesh, x, z) in casters {
        let turn = Quat::from_rotation_y(0.3 * x + 0.2);
        let place = Affine3A::from_rotation_translation(turn, Vec3::new(x, 0.0, z));
        stage = stage.put_many(mesh, [place]);
    }
    stage
        .light(light)
        .shoot([0.6, 4.6, 5.2], [0.15, 0.1, 0.05], 44.0, SMALL)
}

pub(crate) fn broken_meshes() -> Scene {
    broken_scene("broken-meshes", sun(0.6, -1.0, -0.25))
}

pub(crate) fn broken_meshes_lamp() -> Scene {
    broken_scene("broken-meshes-lamp", bulb(-0.9, 3.0, 0.1))
}

fn double_mesh(mut mesh: Mesh) -> Mesh {
    mesh.triangles.extend_from_within(..);
    mesh
}

/// Returns the indices of the triangles that face along `normal`.
fn side(mesh: &Mesh, normal: Vec3) -> Vec<usize> {
    (0..mesh.triangles.len())
        .filter(|&i| mesh.normals[mesh.triangles[i][0] as usize] == normal)
        .collect()
}

/// Adds a vertex in the middle of the lid's edge towards +z. The side below doesn't have it.
fn with_t_junction(mut mesh: Mesh) -> Mesh {
    let lid = side(&mesh, Vec3::Y);
    let min = Vec3::new(-0.35, 0.8, -0.35);
    let max = Vec3::new(0.35, 0.8, 0.35);
    let base = mesh.positions.len() as u32;
    mesh.positions.extend([
        min.with_z(max.z),
        Vec3::new(0.0, 0.8, max.z),
        max,
        max.with_z(min.z),
        min,
    ]);
    mesh.normals.extend([Vec3::Y; 5]);
    mesh.uvs.clear();
    mesh.triangles[lid[0]] = [base, base + 1, base + 4];
    mesh.triangles[lid[1]] = [base + 1, base + 3, base + 4];
    mesh.triangles.push([base + 1, base + 2, base + 3]);
    mesh
}

fn mesh_with_hole(mut mesh: Mesh) -> Mesh {
    let lid = side(&mesh, Vec3::Y);
    mesh.triangles.remove(lid[0]);
    mesh
}

/// Adds a sheet on the lid's edge towards +x.
fn add_fin(mut mesh: Mesh) -> Mesh {
    let fin = quad([
        Vec3::new(0.35, 0.8, -0.35),
        Vec3::new(0.35, 0.8, 0.35),
        Vec3::new(0.35, 1.3, 0.35),
        Vec3::new(0.35, 1.3, -0.35),
    ]);
    let base = mesh.positions.len() as u32;
    mesh.positions.extend(&fin.positions);
    mesh.normals.extend([Vec3::NEG_X; 4]);
    mesh.uvs.clear();
    mesh.triangles
        .extend(fin.triangles.iter().map(|t| t.map(|v| v + base)));
    mesh
}

/// Returns two boxes with a common upright edge.
fn touching_mesh() -> Mesh {
    let mut mesh = block([-0.4, 0.0, -0.4], [0.0, 0.8, 0.0]);
    let other = block(Vec3::ZERO, [0.4, 0.8, 0.4]);
    let base = mesh.positions.len() as u32;
    mesh.positions.extend(other.positions);
    mesh.normals.extend(other.normals);
    mesh.uvs.extend(other.uvs);
    mesh.triangles
        .extend(other.triangles.iter().map(|t| t.map(|v| v + base)));
    mesh
}

fn flip_triangle(mut mesh: Mesh) -> Mesh {
    for i in side(&mesh, Vec3::NEG_X) {
        mesh.triangles[i].swap(0, 1);
    }
    mesh
}

/// Number of rows of [`ten_thousand_boxes`], and of boxes in each row.
const BOXES_A_SIDE: i32 = 100;

/// Returns a box's random size, turn and shift within its square metre of the floor.
fn box_place(column: i32, row: i32) -> Affine3A {
    let random = |what: i32| uniform(IVec3::new(column, row, what));
    let size = Vec3::new(
        0.2 + 0.2 * random(2),
        0.1 + 0.5 * random(3),
        0.2 + 0.2 * random(4),
    );
    let turn = Quat::from_rotation_y(3.0 * random(5));
    let place = Vec3::new(
        along_floor(column, random(0)),
        0.0,
        along_floor(row, random(1)),
    );
    Affine3A::from_scale_rotation_translation(size, turn, place)
}

/// Returns a box's x or z, metres, from its column or row and its shift within that, 0 to 1.
fn along_floor(index: i32, shift: f32) -> f32 {
    index as f32 - 0.5 * (BOXES_A_SIDE as f32 - 1.0) + 0.6 * (shift - 0.5)
}

/// Small boxes on a floor, each with a shadow volume as long as the floor.
pub(crate) fn ten_thousand_boxes() -> Scene {
    let mut places = Vec::new();
    for column in 0..BOXES_A_SIDE {
        for row in 0..BOXES_A_SIDE {
            places.push(box_place(column, row));
        }
    }
    let half = 0.5 * BOXES_A_SIDE as f32 + 1.0;
    let unit_box = block([-0.5, 0.0, -0.5], [0.5, 1.0, 0.5]);
    Stage::new("ten-thousand-boxes")
        .put(grid([half, half], [1, 1], |_, _| 0.0))
        .put_many(unit_box, places)
        .light(sun(1.0, -0.12, 0.3))
        .shoot([-6.0, 9.0, 40.0], [0.0, 0.0, 14.0], 45.0, speed::SIZE)
}
