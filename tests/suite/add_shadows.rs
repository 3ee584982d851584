//! Tests that the programs of the page "Add shadows to my renderer" draw shadows. (`pages.rs`
//! compares the page with them.)

#[allow(dead_code, reason = "a program, of which the test needs a part")]
#[path = "../../examples/add_shadows/deferred.rs"]
mod deferred;
#[allow(dead_code, reason = "a program, of which the test needs a part")]
#[path = "../../examples/add_shadows/figures.rs"]
mod figures;
#[allow(dead_code, reason = "a program, of which the test needs a part")]
#[path = "../../examples/add_shadows/forward.rs"]
mod forward;

use glam::{Affine3A, Vec3};
use std::sync::Arc;
use umbrage::{ShadowTechnique, techniques::Pcf};
use umbrage_examples::renderer::BoxScene;
use umbrage_techniques::MapTechnique;

/// Returns the brightness, 0 to 255, of a visible point.
fn brightness(scene: &BoxScene, pixels: &[u8], point: Vec3) -> u8 {
    let clip = scene.clip_from_world().project_point3(point);
    let size = scene.camera.size.as_vec2();
    let x = (0.5 + 0.5 * clip.x) * size.x;
    let y = (0.5 - 0.5 * clip.y) * size.y;
    pixels[4 * (y as usize * scene.camera.size.x as usize + x as usize)]
}

/// Both programs draw the sun's shadows of some boxes at the right positions, and are equal
/// everywhere.
#[test]
fn both_programs_draw_the_same_shadows() {
    let technique: Arc<dyn ShadowTechnique> = Arc::new(MapTechnique::<Pcf>::default());
    let pictures = [
        forward::picture(Some(&technique)),
        deferred::picture(&technique),
    ];
    let pictures = pictures.map(|picture| picture.expect("draws"));
    let scene = BoxScene::small().expect("valid");
    let sun = scene.lights[0].direction_from(Vec3::ZERO);
    // Test the row that is nearest to the camera, whose shadows are all visible.
    let boxes: Vec<Affine3A> = scene.placements(1.0);
    for place in &boxes[21..25] {
        let middle = Vec3::from(place.translation);
        // Boxes are twice as high as their centres. The ray from here to the sun meets their axis
        // slightly below the top.
        let below_top = middle.with_y(1.7 * middle.y);
        let shadowed = below_top - sun * (below_top.y / sun.y);
        let lit = middle.with_y(0.0) + Vec3::X;
        for pixels in &pictures {
            let (dark, bright) = (
                brightness(&scene, pixels, shadowed),
                brightness(&scene, pixels, lit),
            );
            assert!(
                2 * dark < bright,
                "{dark} at {shadowed}, {bright} at {lit}, where no shadow falls"
            );
        }
    }
    // Masks have steps of 1/255, and normals 11 bits. Some colours therefore differ by a step, and
    // a few pixels at edges have the opposite result of a comparison.
    let differing = pictures[0]
        .iter()
        .zip(&pictures[1])
        .filter(|(a, b)| a.abs_diff(**b) > 2)
        .count();
    assert!(
        differing < pictures[0].len() / 1000,
        "{differing} of {} bytes differ",
        pictures[0].len()
    );
}

/// The sun shines through the holes of the cloth, and the column's shadow moves as it bends.
#[test]
fn figures_of_the_program_draw_their_shadows() {
    let technique: Arc<dyn ShadowTechnique> = Arc::new(MapTechnique::<Pcf>::default());
    let pictures = [1.0, -0.4].map(|seconds| figures::picture(&technique, seconds).expect("draws"));
    let scene = BoxScene::small().expect("valid");
    let sun = scene.lights[0].direction_from(Vec3::ZERO);
    let seen = |pixels: &[u8], point: Vec3| {
        let shadow = point - sun * (point.y / sun.y);
        brightness(&scene, pixels, shadow)
    };
    // Centres of two of the cloth's holes, and the threads between them.
    let on_cloth = |u: f32, v: f32| Vec3::new(3.0 + 3.0 * u, 0.2 + 2.4 * v, 4.5);
    for [hole, thread] in [
        [on_cloth(0.625, 0.375), on_cloth(0.5, 0.375)],
        [on_cloth(0.625, 0.625), on_cloth(0.625, 0.5)],
    ] {
        let (bright, dark) = (seen(&pictures[0], hole), seen(&pictures[0], thread));
        assert!(2 * dark < bright, "{dark} at {thread}, {bright} at {hole}");
    }
    // The same point of the column's axis, bent and upright.
    let upright = Vec3::new(1.5, 3.6, 6.0);
    let bent = figures::bend(1.0).transform_point3(upright);
    assert!(bent.distance(upright) > 1.0);
    for (point, dark_in) in [(bent, 0), (upright, 1)] {
        let dark = seen(&pictures[dark_in], point);
        let bright = seen(&pictures[1 - dark_in], point);
        assert!(2 * dark < bright, "{dark} and {bright} at {point}");
    }
}
