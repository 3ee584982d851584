//! Points without a camera: their answers are those of rays, in the caller's rows.

use glam::{DVec3, Vec3};
use umbrage_core::{
    Anchor, Backend, Geometry, Instance, Light, Mesh, PointReceivers, Scene, ShadowTechnique,
};
use umbrage_cpu::Cpu;
use umbrage_techniques::{Exact, Traced};

const SUN: Light = Light::Directional {
    direction: Vec3::new(0.4, -0.8, 0.3),
    angular_diameter: 0.0,
};

/// Answers of points above and below a square of 2 m at a height of 1 m, in UTM coordinates.
#[test]
fn points_have_the_answers_of_their_rays() {
    let far = DVec3::new(691_000.0, 520.0, -5_335_000.0);
    let anchor = Anchor::nearest_to(far).expect("a good anchor");
    let corner = |x: f64, z: f64| anchor.position(far + DVec3::new(x, 1.0, z));
    let corners = vec![
        corner(-1.0, -1.0),
        corner(-1.0, 1.0),
        corner(1.0, 1.0),
        corner(1.0, -1.0),
    ];
    let square = Mesh::new("square", corners, vec![[0, 1, 2], [0, 2, 3]]).expect("a good mesh");
    let scene = Scene {
        meshes: vec![square],
        instances: vec![Instance::new(0, glam::Affine3A::IDENTITY)],
        ..Scene::default()
    };
    let geometry = Geometry::bake(&scene).expect("a good scene");
    // A grid of points, not in the order of a sort.
    let mut points = Vec::new();
    for i in 0..4000_u32 {
        let at = i * 1_237 % 4000;
        let [x, z] = [
            f64::from(at % 80) / 20.0 - 2.0,
            f64::from(at / 80) / 12.5 - 2.0,
        ];
        points.push(far + DVec3::new(x + 0.003, f64::from(i % 3), z + 0.003));
    }
    let to_sun = SUN.direction_from(Vec3::ZERO).as_dvec3();
    let up = vec![Vec3::Y; points.len()];
    let down = vec![Vec3::NEG_Y; points.len()];
    let techniques: [&dyn ShadowTechnique; 2] = [&Traced::default(), &Exact::default()];
    for technique in techniques {
        let answers = |normals: Option<&[Vec3]>| {
            let receivers =
                PointReceivers::new(&points, normals, &SUN, anchor, 1e-3).expect("good");
            let view = receivers.view(&SUN, &geometry);
            let recipe = technique.recipe(&view).expect("served");
            receivers.in_rows(&Cpu::new().render(&view, &recipe).expect("renders").mask)
        };
        let lit = answers(None);
        for (point, &visibility) in points.iter().zip(&lit) {
            // The ray meets the square's plane here.
            let p = *point - far;
            let met = p + to_sun * ((1.0 - p.y) / to_sun.y);
            let is_dark = p.y < 0.999 && met.x.abs() < 1.0 && met.z.abs() < 1.0;
            assert_eq!(visibility == 0.0, is_dark, "{p}");
        }
        assert_eq!(answers(Some(&up)), lit);
        // Normals that face away are dark.
        assert!(
            answers(Some(&down))
                .iter()
                .all(|&visibility| visibility == 0.0)
        );
    }
    let good = |points: &[DVec3], normals: Option<&[Vec3]>, anchor| {
        PointReceivers::new(points, normals, &SUN, anchor, 1e-3).map_err(|error| error.to_string())
    };
    let zero = good(&points[..1], Some(&[Vec3::ZERO]), anchor).expect_err("no direction");
    assert!(zero.starts_with("normal 0: is zero"), "{zero}");
    let rounded = good(&points, None, Anchor::ORIGIN).expect_err("an anchor far away");
    assert!(
        rounded.contains("m in 32 bits; use finite positions, an anchor nearby"),
        "{rounded}"
    );
    assert!(good(&points, Some(&up[1..]), anchor).is_err() && good(&[], None, anchor).is_err());
}
