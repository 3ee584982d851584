//! Cameras.

use super::{document::element_name, nodes::PlacedNode};
use crate::lone_model::SIZE;
use gltf::{
    Camera as FileCamera,
    camera::{Orthographic, Perspective, Projection},
};
use umbrage_core::glam::{Affine3A, DVec3, Mat4, UVec2, Vec4};
use umbrage_core::light_space::{Extents, look_along, orthographic, perspective};
use umbrage_core::{Camera, Invalid, MAX_SIDE, invalid};

/// Returns the camera of a node. Its image has the height of that of a model without a camera, and
/// the camera's aspect ratio.
pub(super) fn camera(camera: &FileCamera<'_>, node: &PlacedNode<'_>) -> Result<Camera, Invalid> {
    read(camera, node)
        .map_err(|e| e.within_context(element_name("camera", camera.index(), camera.name())))
}

fn read(camera: &FileCamera<'_>, node: &PlacedNode<'_>) -> Result<Camera, Invalid> {
    let eye = node.position()?;
    let forward = node.direction(DVec3::NEG_Z)?;
    let up = node.direction(DVec3::Y)?;
    // The document has been checked to have the projection of the camera's type.
    let (clip_from_view, size) = match camera.projection() {
        Projection::Perspective(file) => perspective_of(&file)?,
        Projection::Orthographic(file) => orthographic_of(&file)?,
    };
    let view_from_world = look_along(eye, forward, up)?;
    let world_from_view = view_from_world.as_dmat4().inverse().as_mat4();
    let camera = Camera {
        world_from_view: Affine3A::from_mat4(world_from_view),
        clip_from_view,
        size,
    };
    camera.validate()?;
    Ok(camera)
}

fn perspective_of(file: &Perspective<'_>) -> Result<(Mat4, UVec2), Invalid> {
    let size = match file.aspect_ratio() {
        Some(aspect) => size_of(aspect)?,
        None => SIZE,
    };
    let near = file.znear();
    invalid::positive("znear", near)?;
    // Without a far plane, start with any value.
    let far = file.zfar().unwrap_or(2.0 * near);
    let aspect = size.x as f32 / size.y as f32;
    let mut clip_from_view = perspective(file.yfov(), aspect, near, far)?;
    if file.zfar().is_none() {
        // Use the limit of the usual rows for depth at infinite far: depth is 1 - near / distance.
        clip_from_view.z_axis = Vec4::new(0.0, 0.0, -1.0, -1.0);
        clip_from_view.w_axis = Vec4::new(0.0, 0.0, -near, 0.0);
    }
    Ok((clip_from_view, size))
}

fn orthographic_of(file: &Orthographic<'_>) -> Result<(Mat4, UVec2), Invalid> {
    invalid::positive("xmag", file.xmag())?;
    invalid::positive("ymag", file.ymag())?;
    let extents = Extents {
        left: -file.xmag(),
        right: file.xmag(),
        bottom: -file.ymag(),
        top: file.ymag(),
        near: file.znear(),
        far: file.zfar(),
    };
    let size = size_of(file.xmag() / file.ymag())?;
    Ok((orthographic(extents)?, size))
}

/// Returns the image size for this aspect ratio, width over height.
fn size_of(aspect: f32) -> Result<UVec2, Invalid> {
    invalid::positive("aspect ratio", aspect)?;
    let width = (SIZE.y as f32 * aspect).round();
    Ok(UVec2::new(width.clamp(1.0, MAX_SIDE as f32) as u32, SIZE.y))
}
