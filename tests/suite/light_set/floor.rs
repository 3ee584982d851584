//! A floor without casters, and the analytic shadow of a box on it.

use bytemuck::cast_slice;
use glam::{Affine3A, UVec2, Vec2, Vec3};
use umbrage_core::{Aabb, Camera, Light};
use umbrage_tests::{adapter::device, foreign};
use umbrage_wgpu::{CasterMesh, LightSet, VertexLayout};
use wgpu::BufferUsages;

/// Points of the floor.
pub(super) const SIZE: UVec2 = UVec2::new(96, 64);

/// A box in world space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub(super) center: Vec3,
    /// Half its size.
    pub(super) half: Vec3,
}

/// Returns the camera, which sees the floor but not the box.
pub(super) fn camera() -> Camera {
    let eye = Vec3::new(0.0, 3.0, 10.0);
    Camera::perspective(eye, Vec3::ZERO, Vec3::Y, 0.5, [0.1, 80.0], SIZE).expect("valid")
}

/// Returns the position of a point of [`ForwardProgram::floor`].
fn floor_point(x: i32, y: i32) -> Vec3 {
    let at = (Vec2::new(x as f32, y as f32) - SIZE.as_vec2() * 0.5) * 0.25;
    Vec3::new(at.x + 0.03, 0.0, at.y + 0.01)
}

/// Returns whether the segment from `p` towards the light meets the block.
fn is_hidden(p: Vec3, block: &Block, light: &Light) -> bool {
    let to_light = match light.position() {
        Some(position) => position - p,
        None => light.direction_from(p) * 100.0,
    };
    let a = (block.center - block.half - p) / to_light;
    let b = (block.center + block.half - p) / to_light;
    let enters = a.min(b).max_element();
    let leaves = a.max(b).min_element();
    enters <= leaves && leaves >= 0.0 && enters <= 1.0
}

/// Returns the corners of a box around the origin, three for each triangle.
pub(super) fn box_corners(half: Vec3) -> Vec<[f32; 3]> {
    let corner = |i: u32| {
        let side = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        (half * Vec3::new(side(0), side(1), side(2))).to_array()
    };
    let sides: [[u32; 4]; 6] = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    sides
        .iter()
        .flat_map(|&[a, b, c, d]| [a, b, c, a, c, d])
        .map(corner)
        .collect()
}

/// Adds a block to a set as a caster.
pub(super) fn add_block(set: &mut LightSet, block: &Block) {
    let Block { center, half } = *block;
    let corners = box_corners(half);
    let vertices = foreign::buffer(device(), BufferUsages::VERTEX, cast_slice(&corners));
    let mesh = CasterMesh {
        label: "box",
        vertices: &vertices,
        layout: VertexLayout::PACKED,
        indices: None,
        range: 0..corners.len() as u32,
        base_vertex: 0,
        bounds: Aabb {
            min: -half,
            max: half,
        },
    };
    let mesh = set.add_mesh(&mesh).expect("valid");
    let place = Affine3A::from_translation(center);
    set.add_caster(mesh, place).expect("valid");
}

/// Returns the analytic mask at the points that the camera sees; `None` elsewhere, and within
/// `border` points of the shadow's edge.
pub(super) fn expected(light: &Light, block: &Block, border: i32) -> Vec<Option<f32>> {
    let clip_from_world = camera().space().clip_from_world();
    let hidden_at = |x: i32, y: i32| is_hidden(floor_point(x, y), block, light);
    let value = |x: i32, y: i32| {
        let clip = clip_from_world.project_point3(floor_point(x, y));
        let is_seen = clip.x.abs() < 1.0 && clip.y.abs() < 1.0 && clip.z < 1.0;
        let hidden = hidden_at(x, y);
        let mut around =
            (-border..=border).flat_map(|dy| (-border..=border).map(move |dx| (dx, dy)));
        let is_inner = around.all(|(dx, dy)| hidden_at(x + dx, y + dy) == hidden);
        (is_seen && is_inner).then_some(if hidden { 0.0 } else { 1.0 })
    };
    (0..SIZE.y as i32)
        .flat_map(|y| (0..SIZE.x as i32).map(move |x| value(x, y)))
        .collect()
}

/// Returns the number of points at which a mask isn't the analytic one, to within `tolerance`.
pub(super) fn wrong_points(mask: &[f32], expected: &[Option<f32>], tolerance: f32) -> usize {
    let shadowed = expected.iter().filter(|&&v| v == Some(0.0)).count();
    assert!(shadowed > 20, "only {shadowed} points in shadow");
    let is_wrong = |(found, expected): (&f32, &Option<f32>)| {
        expected.is_some_and(|expected| (found - expected).abs() > tolerance)
    };
    mask.iter()
        .zip(expected)
        .filter(|&pair| is_wrong(pair))
        .count()
}
