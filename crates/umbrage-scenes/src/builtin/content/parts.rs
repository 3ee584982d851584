//! Building blocks for the meshes of the scenes.

use crate::primitives::{block, on_circle, tube};
use std::collections::HashMap;
use umbrage_core::Mesh;
use umbrage_core::glam::{Affine3A, Quat, Vec2, Vec3};

/// Cosine of the crease angle. Faces that meet at a larger angle don't share shading normals.
const CREASE: f32 = 0.75;
/// Sides of a stick and of a wire.
const STICK_SIDES: u32 = 8;
const WIRE_SIDES: u32 = 5;
/// Segments of a hanging wire.
const WIRE_PIECES: u32 = 16;

/// Returns a translation.
pub(super) fn translation(x: f32, y: f32, z: f32) -> Affine3A {
    Affine3A::from_translation(Vec3::new(x, y, z))
}

/// Returns a turn about the y axis, radians, followed by a translation.
pub(super) fn turned_placement(place: impl Into<Vec3>, angle: f32) -> Affine3A {
    Affine3A::from_rotation_translation(Quat::from_rotation_y(angle), place.into())
}

/// Returns a scale, a turn about the y axis, radians, and a translation, in this order.
pub(super) fn scaled_placement(
    place: impl Into<Vec3>,
    angle: f32,
    scale: impl Into<Vec3>,
) -> Affine3A {
    let turn = Quat::from_rotation_y(angle);
    Affine3A::from_scale_rotation_translation(scale.into(), turn, place.into())
}

/// Returns a transformed mesh. `place` must not mirror.
pub(super) fn transform_mesh(mut mesh: Mesh, place: Affine3A) -> Mesh {
    let normals_from_local = place.matrix3.inverse().transpose();
    for position in &mut mesh.positions {
        *position = place.transform_point3(*position);
    }
    for normal in &mut mesh.normals {
        *normal = (normals_from_local * *normal).normalize_or_zero();
    }
    mesh
}

/// Returns the area-weighted sum of the triangle normals at each vertex.
fn averaged_normals(mesh: &Mesh) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let normal = area_normal(mesh, *triangle);
        for &vertex in triangle {
            normals[vertex as usize] += normal;
        }
    }
    normals
}

/// Returns a triangle's normal, with a length of twice its area.
fn area_normal(mesh: &Mesh, triangle: [u32; 3]) -> Vec3 {
    let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
    (b - a).cross(c - a)
}

/// Merges meshes into one, without textures.
pub(super) fn merge_parts(name: &str, parts: impl IntoIterator<Item = Mesh>) -> Mesh {
    let mut out = Mesh {
        name: name.to_owned(),
        ..Mesh::default()
    };
    for part in parts {
        let first = out.positions.len() as u32;
        if part.normals.is_empty() {
            out.normals.extend(averaged_normals(&part));
        } else {
            out.normals.extend(part.normals);
        }
        out.positions.extend(part.positions);
        let triangles = part.triangles.iter();
        out.triangles
            .extend(triangles.map(|t| t.map(|vertex| vertex + first)));
    }
    out
}

/// Returns a mesh with smooth shading, except at its creases.
pub(super) fn crease_mesh(mesh: &Mesh) -> Mesh {
    let mut faces = Vec::with_capacity(mesh.triangles.len());
    let mut faces_at = vec![Vec::new(); mesh.positions.len()];
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        faces.push(area_normal(mesh, *triangle));
        for &vertex in triangle {
            faces_at[vertex as usize].push(face);
        }
    }
    let mut out = Mesh {
        name: mesh.name.clone(),
        ..Mesh::default()
    };
    let mut known = HashMap::new();
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        let own = faces[face].normalize_or_zero();
        let corners = triangle.map(|vertex| {
            let around = faces_at[vertex as usize].iter().map(|&face| faces[face]);
            let smooth = around.filter(|n| n.normalize_or_zero().dot(own) > CREASE);
            let normal = smooth.sum::<Vec3>();
            let key = (vertex, normal.to_array().map(f32::to_bits));
            *known.entry(key).or_insert_with(|| {
                out.positions.push(mesh.positions[vertex as usize]);
                out.normals.push(normal);
                out.positions.len() as u32 - 1
            })
        });
        out.triangles.push(corners);
    }
    out
}

/// Returns an open sheet of `cells` quads along u and v, from its points at (u, v), each 0 to 1. It
/// faces along the cross product of growing v and growing u.
pub(super) fn sheet(cells: [u32; 2], point: impl Fn(f32, f32) -> Vec3) -> Mesh {
    let [across, along] = cells;
    let mut out = Mesh {
        name: "sheet".to_owned(),
        ..Mesh::default()
    };
    for k in 0..=along {
        let v = k as f32 / along as f32;
        for i in 0..=across {
            let u = i as f32 / across as f32;
            out.positions.push(point(u, v));
            out.uvs.push(Vec2::new(u, v));
        }
    }
    for k in 0..along {
        for i in 0..across {
            let a = k * (across + 1) + i;
            let b = a + across + 1;
            out.triangles.push([a, b, b + 1]);
            out.triangles.push([a, b + 1, a + 1]);
        }
    }
    out
}

/// Returns a box from its centre and half its size.
pub(super) fn box_at(middle: impl Into<Vec3>, half: impl Into<Vec3>) -> Mesh {
    let (middle, half) = (middle.into(), half.into());
    block(middle - half, middle + half)
}

/// Returns a straight round stick.
pub(super) fn stick(from: impl Into<Vec3>, to: impl Into<Vec3>, radius: f32) -> Mesh {
    let ends = [(from.into(), radius), (to.into(), radius)];
    crease_mesh(&tube(&ends, STICK_SIDES))
}

/// Returns a wire that hangs between two points, `sag` below them in its middle.
pub(super) fn wire(from: Vec3, to: Vec3, sag: f32, radius: f32) -> Mesh {
    let mut path = Vec::new();
    for i in 0..=WIRE_PIECES {
        let t = i as f32 / WIRE_PIECES as f32;
        let below = 4.0 * sag * t * (1.0 - t);
        path.push((from.lerp(to, t) - below * Vec3::Y, radius));
    }
    tube(&path, WIRE_SIDES)
}

/// Returns a smooth tube through points with radii, with `pieces` segments between neighbours.
pub(super) fn smooth_tube(knots: &[(Vec3, f32)], pieces: u32, sides: u32) -> Mesh {
    let mut path = vec![knots[0]];
    for i in 1..knots.len() {
        let ends = [knots[i - 1], knots[i]];
        let before = knots[i.saturating_sub(2)];
        let after = knots[(i + 1).min(knots.len() - 1)];
        for k in 1..=pieces {
            let t = k as f32 / pieces as f32;
            path.push(knot_between([before, ends[0], ends[1], after], t));
        }
    }
    tube(&path, sides)
}

/// Returns a point of the Catmull-Rom curve between the second and the third of four knots, and its
/// radius.
fn knot_between(knots: [(Vec3, f32); 4], t: f32) -> (Vec3, f32) {
    let weights = [
        0.5 * t * (t * (2.0 - t) - 1.0),
        0.5 * (t * t * (3.0 * t - 5.0) + 2.0),
        0.5 * t * (t * (4.0 - 3.0 * t) + 1.0),
        0.5 * t * t * (t - 1.0),
    ];
    let mut point = Vec3::ZERO;
    let mut radius = 0.0;
    for (knot, weight) in knots.into_iter().zip(weights) {
        point += knot.0 * weight;
        radius += knot.1 * weight;
    }
    let thinnest = 0.5 * knots[1].1.min(knots[2].1);
    (point, radius.max(thinnest))
}

/// Returns the outline of an opening with a half circle above `spring`, from its left foot to its
/// right one.
pub(super) fn arch_outline(middle: f32, half: f32, foot: f32, spring: f32) -> Vec<(f32, f32)> {
    const PIECES: u32 = 24;
    let mut out = vec![(middle - half, foot)];
    for i in 0..=PIECES {
        let turn = 0.5 - 0.5 * f64::from(i) / f64::from(PIECES);
        let (cos, sin) = on_circle(turn);
        out.push((middle + half * cos, spring + half * sin));
    }
    out.push((middle + half, foot));
    out
}

/// Returns the outline of a wall over `-half..half` and `foot..top`. The openings, from left to
/// right, cut it from below.
pub(super) fn pierced_wall(
    half: f32,
    foot: f32,
    top: f32,
    openings: &[Vec<(f32, f32)>],
) -> Vec<(f32, f32)> {
    let mut out = vec![(half, foot), (half, top), (-half, top), (-half, foot)];
    out.extend(openings.iter().flatten());
    out
}
