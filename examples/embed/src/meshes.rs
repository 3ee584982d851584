//! Meshes made in code, all in one vertex and one index buffer.

use std::{f32::consts::TAU, ops::Range};
use umbrage::{
    Aabb,
    glam::{Vec2, Vec3},
};

/// Position and normal.
pub type Vertex = [f32; 6];

/// A part of the buffers.
pub struct MeshPart {
    pub label: &'static str,
    pub indices: Range<u32>,
    pub base_vertex: i32,
    pub bounds: Aabb,
}

/// All meshes.
#[derive(Default)]
pub struct Meshes {
    pub vertices: Vec<Vertex>,
    pub indices: Vec<u16>,
    pub meshes: Vec<MeshPart>,
}

/// A point of a profile that is turned around the y axis: distance from the axis and height, and the normal there.
#[derive(Clone, Copy)]
struct Ring {
    at: Vec2,
    normal: Vec2,
}

const fn ring(at: [f32; 2], normal: [f32; 2]) -> Ring {
    Ring {
        at: Vec2::from_array(at),
        normal: Vec2::from_array(normal),
    }
}

/// Index of a mesh in [`Meshes::meshes`].
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Shape {
    /// One metre each way, on the ground.
    Box,
    /// Radius and height of one metre, on the ground.
    Cylinder,
    Cone,
    Pyramid,
    /// Radius of one metre, around the origin.
    Ball,
}

impl Meshes {
    /// All shapes, in the order of [`Shape`].
    pub fn new() -> Self {
        let side = [ring([1.0, 0.0], [1.0, 0.0]), ring([1.0, 1.0], [1.0, 0.0])];
        let bottom = [ring([0.0, 0.0], [0.0, -1.0]), ring([1.0, 0.0], [0.0, -1.0])];
        let top = [ring([1.0, 1.0], [0.0, 1.0]), ring([0.0, 1.0], [0.0, 1.0])];
        let slope = [ring([1.0, 0.0], [0.7, 0.7]), ring([0.0, 1.0], [0.7, 0.7])];
        let mut out = Self::default();
        out.add("box", block);
        out.add("cylinder", |vertices| {
            turn(vertices, &[bottom, side, top], 32, true);
        });
        out.add("cone", |vertices| {
            turn(vertices, &[bottom, slope], 32, true);
        });
        out.add("pyramid", |vertices| {
            turn(vertices, &[bottom, slope], 4, false);
        });
        out.add("ball", |vertices| {
            turn(vertices, &half_circle(16), 32, true);
        });
        out
    }

    /// Adds a mesh of quads, four vertices each, counter-clockwise as seen from outside.
    fn add(&mut self, label: &'static str, make: impl FnOnce(&mut Vec<Vertex>)) {
        let base_vertex = self.vertices.len();
        let first_index = self.indices.len() as u32;
        make(&mut self.vertices);
        let added = &self.vertices[base_vertex..];
        for quad in 0..(added.len() / 4) as u16 {
            self.indices
                .extend([0, 1, 2, 0, 2, 3].map(|corner| 4 * quad + corner));
        }
        let positions = added.iter().map(|v| Vec3::new(v[0], v[1], v[2]));
        self.meshes.push(MeshPart {
            label,
            indices: first_index..self.indices.len() as u32,
            base_vertex: base_vertex as i32,
            bounds: Aabb::around(positions),
        });
    }
}

fn vertex(position: Vec3, normal: Vec3) -> Vertex {
    let (p, n) = (position, normal.normalize());
    [p.x, p.y, p.z, n.x, n.y, n.z]
}

/// Adds a box that stands on the ground.
fn block(vertices: &mut Vec<Vertex>) {
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let normal = Vec3::AXES[axis] * side;
            let u = Vec3::AXES[(axis + 1) % 3] * side;
            let v = Vec3::AXES[(axis + 2) % 3];
            for (along_u, along_v) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let corner = normal + u * along_u + v * along_v;
                vertices.push(vertex(0.5 * (corner + Vec3::Y), normal));
            }
        }
    }
}

/// Adds a surface of revolution. Smooth ones have the normals of the round body, others those of their faces.
fn turn(vertices: &mut Vec<Vertex>, profile: &[[Ring; 2]], sides: u32, smooth: bool) {
    let around = |v: Vec2, angle: f32| Vec3::new(v.x * angle.cos(), v.y, v.x * angle.sin());
    for &[low, high] in profile {
        for i in 0..sides {
            let angles = [i, i + 1].map(|i| i as f32 / sides as f32 * TAU);
            let middle = 0.5 * (angles[0] + angles[1]);
            for (ring, angle) in [
                (low, angles[0]),
                (high, angles[0]),
                (high, angles[1]),
                (low, angles[1]),
            ] {
                let facing = if smooth { angle } else { middle };
                let normal = around(ring.normal, facing);
                vertices.push(vertex(around(ring.at, angle), normal));
            }
        }
    }
}

/// The profile of a ball, from the lowest point up.
fn half_circle(parts: u32) -> Vec<[Ring; 2]> {
    let point = |i: u32| {
        let angle = (i as f32 / parts as f32 - 0.5) * 0.5 * TAU;
        let at = [angle.cos().max(0.0), angle.sin()];
        ring(at, at)
    };
    (0..parts).map(|i| [point(i), point(i + 1)]).collect()
}
