//! A camera with the projection of other renderers.

use super::distant::hills;
use umbrage_core::Scene;
use umbrage_core::glam::Vec4;

/// The hills with a camera of reversed, infinite depth: 1 at the near plane, 0 at infinity.
pub(crate) fn hills_endless() -> Scene {
    let mut scene = hills();
    scene.name = "hills-endless".to_owned();
    for camera in &mut scene.cameras {
        // A standard perspective has the depth (a z + b) / -z, with near = b / a.
        let usual = camera.clip_from_view.row(2);
        let near = usual.w / usual.z;
        // Set depth to near / -z: 1 at near, 0 at infinity. Columns of the transpose are rows of
        // the matrix.
        let mut rows = camera.clip_from_view.transpose();
        rows.z_axis = Vec4::W * near;
        camera.clip_from_view = rows.transpose();
    }
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::glam::Vec3;

    #[test]
    fn depth_is_reversed_and_endless() {
        let usual = hills().cameras[0];
        let camera = hills_endless().cameras[0];
        // The near plane of the standard camera.
        let near = usual.clip_from_view.inverse().project_point3(Vec3::ZERO).z;
        let depth = |z: f32| camera.clip_from_view.project_point3(Vec3::Z * z).z;
        assert!((depth(near) - 1.0).abs() < 1e-6, "{}", depth(near));
        assert!((depth(2.0 * near) - 0.5).abs() < 1e-6);
        assert!(depth(1e9 * near) > 0.0);
        // Projected positions don't change.
        let place = Vec3::new(3.0, -2.0, -40.0);
        let seen = camera.clip_from_view.project_point3(place).truncate();
        let usually = usual.clip_from_view.project_point3(place).truncate();
        assert_eq!(seen, usually);
    }
}
