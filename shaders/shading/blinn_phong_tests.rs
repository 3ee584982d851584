//! Colours calculated by hand. The light is above and the camera looks down.

use super::*;
use glam::{Affine3A, UVec2, Vec4};
use umbrage_core::Uniforms;
use umbrage_core::{Extents, Geometry, Instance, Material, Mesh, Texture, math::dot3};

/// A quad of 2 x 2 m in y = 0, viewed from above: u grows along x, v (down the texture) along z.
fn quad() -> Mesh {
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    Mesh {
        name: "quad".to_owned(),
        positions: vec![
            corner(-1.0, -1.0),
            corner(-1.0, 1.0),
            corner(1.0, 1.0),
            corner(1.0, -1.0),
        ],
        normals: vec![Vec3::Y; 4],
        uvs: vec![Vec2::ZERO, Vec2::Y, Vec2::ONE, Vec2::X],
        // Green is up the texture, towards -z: n x t = y x x = -z.
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

fn scene(material: Material, textures: Vec<Texture>) -> Scene {
    let instance = Instance {
        material: Some(0),
        ..Instance::new(0, Affine3A::IDENTITY)
    };
    let meshes = vec![quad()];
    let instances = vec![instance];
    let materials = vec![material];
    Scene {
        name: "quad".to_owned(),
        meshes,
        instances,
        materials,
        textures,
        ..Scene::default()
    }
}

fn flat(name: &str, texel: [f32; 4]) -> Texture {
    Texture {
        name: name.to_owned(),
        size: UVec2::ONE,
        texels: vec![texel].into(),
    }
}

/// Looks straight down from 10 m.
fn camera() -> Camera {
    let extents = Extents {
        left: -2.0,
        right: 2.0,
        bottom: -2.0,
        top: 2.0,
        near: 0.1,
        far: 20.0,
    };
    Camera::orthographic(
        Vec3::Y * 10.0,
        Vec3::ZERO,
        Vec3::NEG_Z,
        extents,
        UVec2::splat(8),
    )
    .unwrap()
}

const MATERIAL: Material = Material {
    diffuse: Vec3::new(0.5, 0.25, 0.125),
    diffuse_texture: None,
    specular: Vec3::splat(0.5),
    shininess_log2: 2,
    emissive: Vec3::ZERO,
    normal_map: None,
    displacement: None,
    alpha: None,
};

/// Shines down from +y and +z: n.l = .8 on the quad.
const SLANTED: Light = Light::Directional {
    direction: Vec3::new(0.0, -0.8, -0.6),
    angular_diameter: 0.0,
};
const ZENITH: Light = Light::Directional {
    direction: Vec3::NEG_Y,
    angular_diameter: 0.0,
};

fn kernel(scene: &Scene, light: &Light, settings: BlinnPhong) -> BlinnPhongKernel {
    let geometry = Geometry::bake(scene).unwrap();
    let camera = camera();
    settings
        .shading(scene, &View::new(&camera, light, &geometry))
        .unwrap()
        .kernel
}

/// Returns the colour at (x, z) of the quad, viewed from above.
fn shade_at(
    scene: &Scene,
    light: &Light,
    settings: BlinnPhong,
    place: [f32; 2],
    visibility: f32,
) -> Vec3 {
    let [x, z] = place;
    // The second triangle is above the diagonal from (-1, -1) to (1, 1).
    let triangle = u32::from(z < x);
    kernel(scene, light, settings)
        .color(triangle, Vec3::new(x, 0.0, z), Vec3::Y, visibility)
        .unwrap()
}

fn assert_near(a: Vec3, b: Vec3) {
    // Allow a few roundings of numbers below 2.
    assert!((a - b).abs().max_element() < 1e-6, "{a} is not {b}");
}

const PLAIN: [f32; 2] = [0.25, 0.5];

#[test]
fn straight_light_by_hand() {
    // n.l = n.h = 1: .15 k + k + .5
    let expected = 1.15 * MATERIAL.diffuse + 0.5;
    assert_near(
        shade_at(
            &scene(MATERIAL, vec![]),
            &ZENITH,
            BlinnPhong::default(),
            PLAIN,
            1.0,
        ),
        expected,
    );
}

#[test]
fn slanted_light_by_hand() {
    // h = (0, 1.8, .6) / sqrt(3.6): (n.h)^4 = (3.24 / 3.6)^2 = .81
    let expected = 0.15 * MATERIAL.diffuse + 0.8 * MATERIAL.diffuse + 0.5 * 0.81;
    assert_near(
        shade_at(
            &scene(MATERIAL, vec![]),
            &SLANTED,
            BlinnPhong::default(),
            PLAIN,
            1.0,
        ),
        expected,
    );
    // Power 8 squares the highlight.
    let sharper = Material {
        shininess_log2: 3,
        ..MATERIAL
    };
    let expected = 0.95 * MATERIAL.diffuse + 0.5 * 0.81 * 0.81;
    assert_near(
        shade_at(
            &scene(sharper, vec![]),
            &SLANTED,
            BlinnPhong::default(),
            PLAIN,
            1.0,
        ),
        expected,
    );
}

#[test]
fn ambient_light_and_emission_stay_in_full_shadow() {
    let glowing = Material {
        emissive: Vec3::new(0.0, 0.0, 0.75),
        ..MATERIAL
    };
    let settings = BlinnPhong {
        ambient: Vec3::new(0.5, 0.25, 0.5),
        ..BlinnPhong::default()
    };
    let dark = shade_at(&scene(glowing, vec![]), &SLANTED, settings, PLAIN, 0.0);
    assert_eq!(dark, Vec3::new(0.25, 0.0625, 0.8125));
    // Half the visibility gives half of the light's contribution.
    let [half, full] =
        [0.5, 1.0].map(|v| shade_at(&scene(glowing, vec![]), &SLANTED, settings, PLAIN, v) - dark);
    assert_near(half * 2.0, full);
}

#[test]
fn the_lamps_colour_and_distance_count() {
    let lamp = Light::Point {
        position: Vec3::new(0.25, 2.0, 0.5),
        radius: 0.0,
    };
    let matt = scene(
        Material {
            specular: Vec3::ZERO,
            diffuse: Vec3::ONE,
            ..MATERIAL
        },
        vec![],
    );
    let none = BlinnPhong {
        ambient: Vec3::ZERO,
        light: Vec3::new(1.0, 0.5, 0.25),
        ..BlinnPhong::default()
    };
    assert_near(shade_at(&matt, &lamp, none, PLAIN, 1.0), none.light);
    let falling = BlinnPhong {
        attenuation: Vec3::new(1.0, 0.5, 0.5),
        ..none
    };
    assert_near(
        shade_at(&matt, &lamp, falling, PLAIN, 1.0),
        none.light / 4.0,
    );
    assert_near(shade_at(&matt, &ZENITH, falling, PLAIN, 1.0), none.light);
}

#[test]
fn spots_fade_between_their_angles() {
    let matt = scene(
        Material {
            specular: Vec3::ZERO,
            diffuse: Vec3::ONE,
            ..MATERIAL
        },
        vec![],
    );
    let settings = BlinnPhong {
        ambient: Vec3::ZERO,
        ..BlinnPhong::default()
    };
    let spot = |inner: f32, outer: f32| Light::Spot {
        position: Vec3::new(0.0, 1.0, 0.5),
        direction: Vec3::NEG_Y * 3.0,
        inner: inner.acos(),
        outer: outer.acos(),
        radius: 0.0,
    };
    // At (.75, .5) the light arrives at tan = 3/4: cos = .8, and n.l = .8, too.
    let x = [0.75, 0.5];
    assert_near(
        shade_at(&matt, &spot(0.9, 0.7), settings, x, 1.0),
        Vec3::splat(0.8 * 0.5),
    );
    assert_near(
        shade_at(&matt, &spot(0.79, 0.6), settings, x, 1.0),
        Vec3::splat(0.8),
    );
    assert_near(
        shade_at(&matt, &spot(0.95, 0.81), settings, x, 1.0),
        Vec3::ZERO,
    );
    // Test points on both sides of a sharp edge.
    assert_near(
        shade_at(&matt, &spot(0.81, 0.81), settings, x, 1.0),
        Vec3::ZERO,
    );
    assert_near(
        shade_at(&matt, &spot(0.79, 0.79), settings, x, 1.0),
        Vec3::splat(0.8),
    );
}

/// The texels are red, green over blue, white. u points right (x) and v points down the image (z),
/// which the camera also shows downwards.
#[test]
fn textures_lie_as_their_picture_does() {
    let texels = vec![
        [1.0, 0.0, 0.0, 1.0],
        [0.0, 1.0, 0.0, 1.0],
        [0.0, 0.0, 1.0, 1.0],
        [1.0; 4],
    ];
    let texture = Texture {
        name: "2x2".to_owned(),
        size: UVec2::splat(2),
        texels: texels.into(),
    };
    let textured = Material {
        diffuse: Vec3::ONE,
        specular: Vec3::ZERO,
        diffuse_texture: Some(0),
        ..MATERIAL
    };
    let settings = BlinnPhong {
        ambient: Vec3::ZERO,
        ..BlinnPhong::default()
    };
    for (x, color) in [
        ([-0.5, -0.5], Vec3::X),
        ([0.5, -0.5], Vec3::Y),
        ([-0.5, 0.5], Vec3::Z),
        ([0.5, 0.5], Vec3::ONE),
    ] {
        assert_near(
            shade_at(
                &scene(textured, vec![texture.clone()]),
                &ZENITH,
                settings,
                x,
                1.0,
            ),
            color,
        );
    }
}

#[test]
fn a_flat_normal_map_is_none() {
    let map = flat("flat", [0.5, 0.5, 1.0, 1.0]);
    let mapped = Material {
        normal_map: Some(0),
        ..MATERIAL
    };
    for x in [PLAIN, [-0.9, 0.3], [0.61, -0.77]] {
        let [with, without] = [mapped, MATERIAL].map(|m| {
            shade_at(
                &scene(m, vec![map.clone()]),
                &SLANTED,
                BlinnPhong::default(),
                x,
                1.0,
            )
        });
        assert_eq!(
            with.to_array().map(f32::to_bits),
            without.to_array().map(f32::to_bits)
        );
    }
}

/// The map's normal leans by (.6, 0, .8) along the tangent, or along the bitangent. In the first
/// case it is in the plane of the light.
#[test]
fn normal_maps_lean_along_the_textures_axes() {
    let settings = BlinnPhong {
        ambient: Vec3::ZERO,
        ..BlinnPhong::default()
    };
    let matt = Material {
        diffuse: Vec3::ONE,
        specular: Vec3::ZERO,
        normal_map: Some(0),
        ..MATERIAL
    };
    let brightness = |texel: [f32; 3], to_light: Vec3, mirror: f32| {
        let [x, y, z] = texel.map(|v| v * 0.5 + 0.5);
        let mut scene = scene(matt, vec![flat("leaning", [x, y, z, 1.0])]);
        scene.instances[0].world_from_local = Affine3A::from_scale(Vec3::new(mirror, 1.0, 1.0));
        let light = Light::Directional {
            direction: -to_light,
            angular_diameter: 0.0,
        };
        shade_at(&scene, &light, settings, PLAIN, 1.0).x
    };
    let east = Vec3::new(0.6, 0.8, 0.0);
    let north = Vec3::new(0.0, 0.8, -0.6);
    let close = |a: f32, b: f32| assert!((a - b).abs() < 1e-6, "{a} is not {b}");
    // Red leans along u: .36 + .64 = 1 towards the light, .64 - .36 away from it.
    close(brightness([0.6, 0.0, 0.8], east, 1.0), 1.0);
    close(brightness([-0.6, 0.0, 0.8], east, 1.0), 0.28);
    // Green leans up the texture, here towards -z.
    close(brightness([0.0, 0.6, 0.8], north, 1.0), 1.0);
    close(brightness([0.0, -0.6, 0.8], north, 1.0), 0.28);
    // Mirrored along x, u grows towards -x; v still grows towards z.
    close(brightness([0.6, 0.0, 0.8], east, -1.0), 0.28);
    close(brightness([0.0, 0.6, 0.8], north, -1.0), 1.0);
}

/// The normal map leans towards the light; the geometry faces away from it.
#[test]
fn nothing_arrives_below_the_horizon() {
    let leaning = flat("leaning", [1.0, 0.5, 0.5, 1.0]);
    let scene = scene(
        Material {
            normal_map: Some(0),
            ..MATERIAL
        },
        vec![leaning],
    );
    let settings = BlinnPhong {
        ambient: Vec3::ZERO,
        ..BlinnPhong::default()
    };
    let low = |y: f32| Light::Directional {
        direction: Vec3::new(-1.0, y, 0.0),
        angular_diameter: 0.0,
    };
    assert_eq!(
        shade_at(&scene, &low(0.01), settings, PLAIN, 1.0),
        Vec3::ZERO
    );
    assert!(shade_at(&scene, &low(-0.01), settings, PLAIN, 1.0).min_element() > 0.1);
}

/// From below, the quad's normal is -y. A map that leans east then leans west.
#[test]
fn seen_from_behind_a_bump_is_a_dent() {
    let leaning = flat("leaning", [0.8, 0.5, 0.9, 1.0]);
    let matt = Material {
        diffuse: Vec3::ONE,
        specular: Vec3::ZERO,
        normal_map: Some(0),
        ..MATERIAL
    };
    let tables = kernel(&scene(matt, vec![leaning]), &ZENITH, BlinnPhong::default()).tables;
    let normal = |facing: Vec3| {
        tables
            .surface(0, Vec3::new(-0.2, 0.0, 0.1), facing)
            .unwrap()
            .normal
    };
    assert_near(normal(Vec3::Y), Vec3::new(0.6, 0.8, 0.0));
    assert_near(normal(Vec3::NEG_Y), Vec3::new(-0.6, -0.8, 0.0));
}

#[test]
fn smooth_normals_are_weighted() {
    let mut scene = scene(MATERIAL, vec![]);
    scene.meshes[0].normals = vec![Vec3::Y, Vec3::Y, Vec3::X, Vec3::Y];
    let tables = kernel(&scene, &ZENITH, BlinnPhong::default()).tables;
    // Halfway from the corner at (-1, 1) to the one at (1, 1).
    let found = tables
        .surface(0, Vec3::new(0.0, 0.0, 1.0), Vec3::Y)
        .unwrap()
        .normal;
    assert_near(found, Vec3::new(0.5, 0.5, 0.0).normalize());
    assert!((dot3(found, found) - 1.0).abs() < 1e-6);
}

#[test]
fn spans_are_shaded_entry_by_entry_and_strangers_left_out() {
    let kernel = kernel(&scene(MATERIAL, vec![]), &SLANTED, BlinnPhong::default());
    let x = [0.25, 0.5, 0.0];
    let z = [0.5, 0.25, 0.0];
    let zero = [0.0; 3];
    let one = [1.0; 3];
    let triangle = [0, 1, umbrage_core::NO_TRIANGLE];
    let span = Span {
        first: UVec2::ZERO,
        x: &x,
        y: &zero,
        z: &z,
        nx: &zero,
        ny: &one,
        nz: &zero,
        triangle: &triangle,
    };
    let mut out = [[7.0; 4]; 3];
    kernel.shade(&span, &[1.0, 0.0, 1.0], &mut out);
    let lit = kernel
        .color(0, Vec3::new(0.25, 0.0, 0.5), Vec3::Y, 1.0)
        .unwrap();
    let dark = 0.15 * MATERIAL.diffuse;
    assert_eq!(
        out,
        [
            lit.extend(1.0).to_array(),
            dark.extend(1.0).to_array(),
            [7.0; 4]
        ]
    );
}

#[test]
fn tables_are_shared_from_view_to_view_and_added_after_the_recipes_own() {
    let scene = scene(MATERIAL, vec![]);
    let geometry = Geometry::bake(&scene).unwrap();
    let camera = camera();
    let view = View::new(&camera, &ZENITH, &geometry);
    let shading = BlinnPhong::default().shading(&scene, &view).unwrap();
    let traced = umbrage_core::ShadowTechnique::recipe(&crate::Traced::default(), &view).unwrap();
    let own = traced.tables.len();
    let recipe = shading.add_to(traced);
    assert_eq!(
        recipe.shade.as_ref().unwrap().tables,
        (own..own + 4).collect::<Vec<_>>()
    );
    let slanted = shading
        .with_view(&View::new(&camera, &SLANTED, &geometry))
        .unwrap();
    assert!(Arc::ptr_eq(
        &slanted.kernel.tables.vertices,
        &shading.kernel.tables.vertices
    ));
    assert_ne!(
        slanted.kernel.uniforms.to_bytes(),
        shading.kernel.uniforms.to_bytes()
    );
}

#[test]
fn bad_input_is_refused() {
    let scene = scene(MATERIAL, vec![]);
    let geometry = Geometry::bake(&scene).unwrap();
    let camera = camera();
    let view = View::new(&camera, &ZENITH, &geometry);
    for bad in [
        BlinnPhong {
            ambient: Vec3::NEG_X,
            ..BlinnPhong::default()
        },
        BlinnPhong {
            light: Vec3::splat(f32::NAN),
            ..BlinnPhong::default()
        },
        BlinnPhong {
            attenuation: Vec3::ZERO,
            ..BlinnPhong::default()
        },
    ] {
        assert!(bad.shading(&scene, &view).is_err(), "{bad:?}");
    }
    assert!(
        BlinnPhong::default()
            .shading(
                &scene,
                &View {
                    geometry: None,
                    ..view
                }
            )
            .is_err()
    );
    let other = Scene {
        materials: vec![],
        instances: vec![],
        ..scene.clone()
    };
    let why = BlinnPhong::default()
        .shading(&other, &view)
        .unwrap_err()
        .to_string();
    assert!(why.contains("baked from"), "{why}");
}
