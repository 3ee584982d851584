//! Camera files: poses, or a path through them.

use super::{
    camera,
    table::{Table, TextSource},
};
use crate::{FilesOnDisk, SceneError};
use std::path::Path;
use toml::de::DeTable;
use umbrage_core::glam::Affine3A;
use umbrage_core::{Anchor, Camera, Geometry};

/// Greatest number of cameras between two poses of a file.
const MAX_BETWEEN: u32 = 1000;

/// Reads cameras from a file. Each pose is a `[[camera]]` table with the keys of a scene file's
/// `[camera]`. `between` is the number of cameras between neighbouring poses, by default 0.
/// Positions are those of the scene's files, in 64 bits: they are made relative to `anchor`, which is
/// [`Scene::anchor`](umbrage_core::Scene::anchor). A key `anchor` in the file must have the same
/// value. Depth ranges that the file doesn't set are fitted to `geometry`.
///
/// ```toml
/// between = 3   # a path: three more cameras between the two
///
/// [[camera]]
/// eye = [0, 2, 8]
/// target = [0, 1, 0]
///
/// [[camera]]
/// eye = [6, 2, 4]
/// target = [0, 1, 0]
/// ```
///
/// # Errors
/// Returns an error if the file can't be read or has no camera, with the line and a remedy.
pub fn cameras(
    path: &Path,
    geometry: &Geometry,
    anchor: Anchor,
) -> Result<Vec<Camera>, SceneError> {
    let text = super::text_of(path, &FilesOnDisk)?;
    parse(&text, path, geometry, anchor)
}

fn parse(
    text: &str,
    path: &Path,
    geometry: &Geometry,
    anchor: Anchor,
) -> Result<Vec<Camera>, SceneError> {
    let source = TextSource {
        file: path.display().to_string(),
        text,
    };
    let document = DeTable::parse(text).map_err(|e| super::syntax(&source, &e))?;
    let root = Table::root(&source, &document);
    root.only(&["anchor", "camera", "between"])?;
    root.require(
        root.anchor()?.is_none_or(|own| own == anchor),
        "has another anchor than its scene",
        "remove the key `anchor`: cameras share that of the scene",
    )?;
    let between = match root.get("between") {
        Some(item) => item.whole(0..=MAX_BETWEEN)?,
        None => 0,
    };
    let poses = root
        .tables("camera")?
        .iter()
        .map(|table| camera::read(table, geometry, anchor))
        .collect::<Result<Vec<_>, _>>()?;
    root.require(
        !poses.is_empty(),
        "has no [[camera]]",
        "add one with eye = [x, y, z] and target = [x, y, z]",
    )?;
    Ok(path_through(&poses, between))
}

/// Returns the poses, and `between` cameras between each pair of neighbours. They are on the
/// straight line between the two and turn at a constant rate. Their projection is that of the
/// previous pose.
fn path_through(poses: &[Camera], between: u32) -> Vec<Camera> {
    let mut out = Vec::new();
    for pair in poses.windows(2) {
        out.push(pair[0]);
        for step in 1..=between {
            let share = step as f32 / (between + 1) as f32;
            let world_from_view = halfway(&pair[0], &pair[1], share);
            out.push(Camera {
                world_from_view,
                ..pair[0]
            });
        }
    }
    out.extend(poses.last());
    out
}

/// Interpolates between the poses of two cameras; `share` is 0 at the first and 1 at the second.
fn halfway(from: &Camera, to: &Camera, share: f32) -> Affine3A {
    let [(_, from_turn, from_place), (_, to_turn, to_place)] =
        [from, to].map(|camera| camera.world_from_view.to_scale_rotation_translation());
    Affine3A::from_rotation_translation(
        from_turn.slerp(to_turn, share),
        from_place.lerp(to_place, share),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::glam::{DVec3, Vec3, Vec3A};

    fn read(text: &str) -> Result<Vec<Camera>, SceneError> {
        let scene = crate::by_argument("cubes").expect("built in");
        let geometry = Geometry::bake(&scene).expect("valid");
        parse(text, Path::new("path.toml"), &geometry, scene.anchor)
    }

    const TWO: &str = "[[camera]]\neye = [0, 2, 8]\ntarget = [0, 2, 0]\n\
                       [[camera]]\neye = [8, 2, 0]\ntarget = [0, 2, 0]\n";

    #[test]
    fn a_path_goes_evenly_from_pose_to_pose() {
        let path = read(&format!("between = 1\n{TWO}")).expect("a path");
        let eyes: Vec<Vec3> = path.iter().map(Camera::eye).collect();
        assert_eq!(eyes.len(), 3);
        assert!(
            eyes[1].distance(Vec3::new(4.0, 2.0, 4.0)) < 1e-4,
            "{eyes:?}"
        );
        // Half of a quarter turn to the left: the camera still looks at the centre.
        let looks_along = -path[1].world_from_view.matrix3.z_axis;
        let expected = Vec3A::new(-0.5_f32.sqrt(), 0.0, -0.5_f32.sqrt());
        assert!(looks_along.distance(expected) < 1e-4, "{looks_along}");
        assert_eq!(read(TWO).expect("two poses").len(), 2);
    }

    #[test]
    fn places_are_read_relative_to_the_anchor() {
        let near = read(TWO).expect("two poses");
        let text = "anchor = [1024000, 0, 0]\n".to_owned()
            + &TWO.replace("[0,", "[1024000,").replace("[8,", "[1024008,");
        let scene = crate::by_argument("cubes").expect("built in");
        let geometry = Geometry::bake(&scene).expect("valid");
        let anchor = Anchor::nearest_to(DVec3::X * 1_024_000.0).expect("in range");
        let read_at = |anchor| parse(&text, Path::new("path.toml"), &geometry, anchor);
        assert_eq!(read_at(anchor).expect("two poses"), near);
        // The scene is relative to another anchor.
        let error = read_at(Anchor::ORIGIN).unwrap_err().to_string();
        assert!(error.contains("remove the key `anchor`"), "{error}");
    }

    /// A scene at coordinates of a map (UTM), whose camera file repeats the eye and has no anchor.
    #[test]
    fn paths_share_the_anchor_of_a_far_scene() {
        let [x, y, z] = [691_234.375, 412.25, -5_336_543.25];
        let pose = |eye: f64| {
            format!(
                "eye = [{}, {}, {z}]\ntarget = [{x}, {y}, {z}]\n",
                x + eye,
                y + 2.0
            )
        };
        let scene = format!(
            "[camera]\n{}[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0.5]\n\
             [[object]]\nshape = \"box\"\ntranslate = [{x}, {y}, {z}]\n",
            pose(8.0)
        );
        let scene = crate::parse(&scene, "far.toml", "").expect("valid");
        assert_ne!(scene.anchor, Anchor::ORIGIN);
        let geometry = Geometry::bake(&scene).expect("valid");
        let text = format!("[[camera]]\n{}[[camera]]\n{}", pose(8.0), pose(8.125));
        let read = |anchor| parse(&text, Path::new("path.toml"), &geometry, anchor).ok();
        let path = read(scene.anchor).expect("two poses");
        assert_eq!(path[0], scene.cameras[0]);
        // Positions have 64 bits until the anchor is subtracted.
        let step = path[1].eye() - path[0].eye();
        assert!(step.distance(Vec3::X * 0.125) < 1e-4, "{step}");
    }

    #[test]
    fn files_without_cameras_are_refused_with_the_line() {
        let error = |text: &str| read(text).expect_err("no cameras").to_string();
        assert!(error("").contains("has no [[camera]]"));
        assert!(error("betwen = 2").contains("did you mean"));
        assert!(error(&format!("between = -1\n{TWO}")).contains("path.toml:1"));
        assert!(error("[[camera]]\neye = [0, 0, 0]").contains("`camera.target`: is missing"));
        assert!(error("between = [").contains("toml.io"));
    }
}
