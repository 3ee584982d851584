use super::*;
use umbrage_core::glam::{Affine3A, UVec2, Vec2, Vec3};
use umbrage_core::{Displacement, Geometry, Instance, Material, Mesh, Scene};

const SOLIDS: [Solid; 2] = [
    Solid::Sphere { radius: 1.0 },
    Solid::Torus {
        major: 1.0,
        minor: 0.4,
    },
];
const SIZE: UVec2 = UVec2::splat(256);

/// Returns the remaining fraction of the mean distance to the clean surface.
fn left(solid: Solid, amplitude: f32, seed: i32, passes: u32, rounds: u32) -> f64 {
    let noisy = roughen_mesh(&solid.mesh(), amplitude, seed);
    solid.mean_distance(&denoise_mesh(&noisy, SIZE, passes, rounds).unwrap())
        / solid.mean_distance(&noisy)
}

#[test]
fn noise_is_as_strong_as_stated_and_the_same_in_every_run() {
    for solid in SOLIDS {
        let clean = solid.mesh();
        // Vertices are rounded to f32 near 1.
        assert!(solid.mean_distance(&clean) < 1e-7);
        let noisy = roughen_mesh(&clean, 0.02, 7);
        assert!(
            (solid.mean_distance(&noisy) - 0.01).abs() < 3e-4,
            "the mean of uniform numbers is half of the greatest"
        );
        assert_eq!(noisy, roughen_mesh(&clean, 0.02, 7));
        assert_ne!(noisy, roughen_mesh(&clean, 0.02, 8));
    }
}

/// Figures for each noise and solid: one pass, three, and both again with the shape kept.
const DOCUMENTED: [(f32, [[f64; 4]; 2]); 4] = [
    (0.005, [[0.74, 2.19, 0.39, 0.23], [1.03, 3.04, 0.38, 0.23]]),
    (0.01, [[0.47, 1.08, 0.39, 0.22], [0.59, 1.51, 0.38, 0.22]]),
    (0.02, [[0.39, 0.52, 0.38, 0.21], [0.43, 0.75, 0.38, 0.22]]),
    (0.04, [[0.37, 0.28, 0.37, 0.22], [0.38, 0.39, 0.38, 0.23]]),
];

#[test]
fn the_documented_figures_are_measured() {
    let mut wrong = Vec::new();
    for (noise, rows) in DOCUMENTED {
        for (solid, row) in SOLIDS.into_iter().zip(rows) {
            let found = [(1, 0), (3, 0), (1, 8), (3, 8)]
                .map(|(passes, rounds)| left(solid, noise, 7, passes, rounds));
            // The documentation has two digits.
            if found.iter().zip(row).any(|(a, b)| (a - b).abs() > 0.0051) {
                wrong.push(format!("{noise} {solid:?}: {found:.3?}, not {row:?}"));
            }
        }
    }
    let shrunk = SOLIDS
        .map(|solid| 1e3 * solid.mean_distance(&denoise_mesh(&solid.mesh(), SIZE, 1, 0).unwrap()));
    if (shrunk[0] - 1.9).abs() > 0.051 || (shrunk[1] - 2.6).abs() > 0.051 {
        wrong.push(format!("shrinks by {shrunk:.3?} mm"));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn one_plain_pass_takes_half_of_the_noise() {
    for solid in SOLIDS {
        for seed in [7, 8, 9] {
            let left = left(solid, 0.02, seed, 1, 0);
            assert!(left < 0.5, "{solid:?}, seed {seed}: {left}");
        }
    }
}

#[test]
fn one_pass_that_keeps_the_shape_takes_half_of_weak_noise_too() {
    for solid in SOLIDS {
        for amplitude in [0.005, 0.01, 0.02, 0.04] {
            let left = left(solid, amplitude, 7, 1, 8);
            assert!(left < 0.5, "{solid:?}, {amplitude}: {left}");
        }
    }
    let plain = left(SOLIDS[1], 0.005, 7, 1, 0);
    assert!(
        plain > 0.9,
        "a plain pass shrinks the ring by as much as it smooths: {plain}"
    );
}

#[test]
fn more_passes_take_more() {
    for solid in SOLIDS {
        let [one, three] = [1, 3].map(|passes| left(solid, 0.02, 7, passes, 8));
        assert!(three < 0.75 * one, "{solid:?}: {one}, {three}");
    }
}

#[test]
fn a_clean_shape_shrinks_less_if_its_shape_is_kept() {
    for solid in SOLIDS {
        let [plain, kept] = [0, 8].map(|rounds| {
            solid.mean_distance(&denoise_mesh(&solid.mesh(), SIZE, 1, rounds).unwrap())
        });
        assert!(
            plain > 1e-3 && kept < 0.25 * plain,
            "{solid:?}: {plain}, {kept}"
        );
    }
}

#[test]
fn the_wrong_sign_adds_noise() {
    let noisy = roughen_mesh(&SOLIDS[0].mesh(), 0.02, 7);
    let worse = DisplacementMap::from_noisy(&noisy, SIZE)
        .unwrap()
        .apply_to_mesh(&noisy, 1.0)
        .unwrap();
    assert!(SOLIDS[0].mean_distance(&worse) > 1.5 * SOLIDS[0].mean_distance(&noisy));
}

#[test]
fn seams_stay_closed() {
    for solid in SOLIDS {
        let noisy = roughen_mesh(&solid.mesh(), 0.04, 7);
        assert!(
            super::deltas::Surface::new(&noisy, 0).is_ok(),
            "noise doesn't tear it"
        );
        let done = denoise_mesh(&noisy, SIZE, 2, 8).unwrap();
        assert!(super::deltas::Surface::new(&done, 0).is_ok(), "{solid:?}");
        assert_eq!(
            (done.positions.len(), &done.uvs, &done.triangles),
            (noisy.positions.len(), &noisy.uvs, &noisy.triangles)
        );
    }
}

#[test]
fn a_map_tells_when_it_has_too_few_texels() {
    let noisy = roughen_mesh(&SOLIDS[0].mesh(), 0.02, 7);
    let error = |side| {
        let map = DisplacementMap::from_noisy(&noisy, UVec2::splat(side)).unwrap();
        map.largest_error(&noisy, 0).unwrap() / map.scale()
    };
    // Expect the precision of 16 bits over the whole range.
    assert!(error(256) < 2e-5, "{}", error(256));
    assert!(error(16) > 0.5, "{}", error(16));
}

#[test]
fn maps_serve_as_materials() {
    let solid = SOLIDS[1];
    let noisy = roughen_mesh(&solid.mesh(), 0.02, 7);
    let map = DisplacementMap::from_noisy(&noisy, SIZE).unwrap();
    let (texture, lambda) = map.texture();
    let displacement = Some(Displacement {
        texture: 0,
        lambda: -lambda,
        subdivisions: 0,
    });
    let scene = Scene {
        meshes: vec![noisy.clone()],
        textures: vec![texture],
        materials: vec![Material {
            displacement,
            ..Material::default()
        }],
        instances: vec![Instance {
            material: Some(0),
            ..Instance::new(0, Affine3A::IDENTITY)
        }],
        ..Scene::default()
    };
    let baked = Geometry::bake(&scene).unwrap();
    let drawn = Mesh {
        positions: baked.positions().to_vec(),
        ..noisy.clone()
    };
    let drawn = solid.mean_distance(&drawn);
    let before = solid.mean_distance(&noisy);
    assert!(drawn < 0.5 * before, "{drawn} of {before}");
}

#[test]
fn saved_maps_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("noise.png");
    let map = DisplacementMap::from_noisy(
        &roughen_mesh(&SOLIDS[0].mesh(), 0.02, 7),
        UVec2::new(64, 32),
    )
    .unwrap();
    map.save(&path).unwrap();
    assert_eq!(DisplacementMap::load(&path).unwrap(), map);
    assert_eq!(image::image_dimensions(&path).unwrap(), (64, 32));
    // Simulate a program that only supports 8-bit colours.
    image::open(&path).unwrap().to_rgb8().save(&path).unwrap();
    let coarse = DisplacementMap::load(&path).unwrap();
    assert_eq!(
        (coarse.scale(), coarse.bias(), coarse.size()),
        (map.scale(), map.bias(), map.size())
    );
    let worst = coarse
        .greys
        .iter()
        .zip(&map.greys)
        .map(|(a, b)| a.abs_diff(*b))
        .max()
        .unwrap();
    assert!(worst > 0 && worst <= 129, "half a step of 8 bits: {worst}");
}

#[test]
fn files_that_hold_no_map_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (path, metres) = (
        folder.path().join("noise.png"),
        folder.path().join("noise.png.toml"),
    );
    let message = || DisplacementMap::load(&path).unwrap_err().to_string();
    let map = DisplacementMap::from_noisy(&SOLIDS[0].mesh(), UVec2::splat(8)).unwrap();
    map.save(&path).unwrap();
    for (text, why) in [
        (
            "scale = 1",
            "`bias`: is missing or not a number; add `bias = 0.01`",
        ),
        (
            "scale = \"1\"\nbias = 0",
            "`scale`: is missing or not a number",
        ),
        ("scale = -1\nbias = 0", "`scale`: is -1"),
        ("scale = 1\nbias = nan", "`bias`: holds NaN"),
        ("scale", "scale and bias of the map"),
    ] {
        std::fs::write(&metres, text).unwrap();
        assert!(
            message().contains("noise.png.toml: ") && message().contains(why),
            "{}",
            message()
        );
    }
    std::fs::remove_file(&metres).unwrap();
    assert!(
        message().contains("noise.png.toml: can't be read"),
        "{}",
        message()
    );
    let nowhere = map
        .save(folder.path().join("none").join("noise.png"))
        .unwrap_err()
        .to_string();
    assert!(
        nowhere.contains("can't be written") && nowhere.contains("check that its folder exists"),
        "{nowhere}"
    );
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let sphere = SOLIDS[0].mesh();
    let message = |mesh: &Mesh, size| {
        DisplacementMap::from_noisy(mesh, size)
            .unwrap_err()
            .to_string()
    };
    let mut open = sphere.clone();
    open.triangles.pop();
    assert!(
        message(&open, SIZE)
            .contains("mesh `sphere`: is open: no second triangle meets the edge from")
    );
    assert!(
        message(
            &Mesh {
                uvs: Vec::new(),
                ..sphere.clone()
            },
            SIZE
        )
        .contains("has no texture coordinates")
    );
    let tiled = Mesh {
        uvs: sphere
            .uvs
            .iter()
            .map(|uv| *uv * Vec2::new(2.0, 1.0))
            .collect(),
        ..sphere.clone()
    };
    assert!(message(&tiled, SIZE).contains("beyond 0 to 1"));
    assert!(message(&sphere, UVec2::new(1, 64)).contains("is 1 x 64 texels; use 2 to 8192 a side"));
    assert!(
        denoise_mesh(&sphere, UVec2::ZERO, 0, 0).is_ok_and(|mesh| mesh == sphere),
        "no pass changes nothing"
    );
    let map = DisplacementMap::from_noisy(&sphere, SIZE).unwrap();
    assert!(map.apply_to_mesh(&sphere, f32::NAN).is_err());
}

#[test]
fn clustered_coordinates_are_searched_all_the_same() {
    // Put all vertices on one point of the texture: the offset of the first one is everywhere.
    let sphere = SOLIDS[0].mesh();
    let one = Mesh {
        uvs: vec![Vec2::splat(0.5); sphere.uvs.len()],
        ..sphere
    };
    let map = DisplacementMap::from_noisy(&one, UVec2::splat(8)).unwrap();
    assert!(map.greys.iter().all(|grey| *grey == map.greys[0]));
    let lines = Mesh {
        uvs: one
            .positions
            .iter()
            .map(|p: &Vec3| Vec2::new(0.25, 0.5 + 0.5 * p.y))
            .collect(),
        ..one
    };
    assert!(DisplacementMap::from_noisy(&lines, UVec2::splat(8)).is_ok());
}
