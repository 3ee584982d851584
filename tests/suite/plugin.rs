//! Tests of a technique from outside the library, on both backends, without built-in support.

use glam::UVec2;
use umbrage::{Backend, Geometry, ShadowTechnique, View, techniques::ShadowMap};
use umbrage_cpu::Cpu;
use umbrage_examples::variance::Variance;
use umbrage_lab::{
    compare::{self, Backends, SceneInput},
    stability,
};
use umbrage_plan::catalogue::{Catalogue, CatalogueEntry};
use umbrage_plan::{self as plan, footprint};
use umbrage_techniques::TechniquePreset;
use umbrage_tests::gpu::gpu;

#[test]
fn a_users_technique_runs_on_both_backends() {
    let scene = umbrage::scenes::by_argument("cubes").expect("a built-in scene");
    let geometry = Geometry::bake(&scene).expect("valid");
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let technique = Variance {
        map: ShadowMap {
            size: 256,
            ..ShadowMap::default()
        },
        radius: 3,
        least_variance: 1e-6,
    };
    let recipe = technique
        .recipe(&view)
        .expect("variance maps serve the sun");
    let cpu = Cpu::new().render(&view, &recipe).expect("renders");
    let gpu = gpu().render(&view, &recipe).expect("renders");
    let soft = cpu.mask.iter().filter(|&&v| v > 0.05 && v < 0.95).count();
    assert!(
        soft > 100,
        "a variance map has soft edges, here {soft} pixels"
    );
    // Sums of at most 7 products near 1, each rounded; the inequality divides by at least 1e-6.
    let worst = cpu
        .mask
        .iter()
        .zip(&gpu.mask)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f32::max);
    assert!(worst <= 1.0 / 255.0, "the backends differ by {worst}");
}

/// The use of an external technique's maps is reported like that of built-in ones.
#[test]
fn a_users_map_has_figures() {
    let scene = umbrage::scenes::by_argument("cubes").expect("a built-in scene");
    let geometry = Geometry::bake(&scene).expect("valid");
    let receivers = Cpu::new()
        .receivers(&scene.cameras[0], &geometry)
        .expect("valid");
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry).with_receivers(&receivers);
    let catalogue = catalogue();
    let map = ShadowMap {
        size: 256,
        ..ShadowMap::default()
    };
    let of = |radius: u32| {
        let technique = Variance {
            map,
            radius,
            least_variance: 1e-6,
        };
        let recipe = technique
            .recipe(&view)
            .expect("variance maps serve the sun");
        let preset = TechniquePreset::from(technique);
        let used = footprint::recipe_footprint(&preset, &view, &recipe, &receivers, &catalogue);
        let used = used.expect("it has a map");
        assert_eq!(
            used,
            footprint::measure(
                &view,
                &recipe,
                &receivers,
                radius as f32,
                catalogue.kernel(&recipe)
            ),
            "the blur's reach"
        );
        used.total
    };
    let [narrow, wide] = [0, 8].map(of);
    assert!(narrow.side.is_some() && narrow.unused > 0.0, "{narrow:?}");
    assert!(
        wide.unused < narrow.unused,
        "{wide:?} against {narrow:?}: a wider blur takes in more texels"
    );
}

fn catalogue() -> Catalogue {
    Catalogue::built_in()
        .with(CatalogueEntry::for_technique::<Variance>())
        .expect("a new name")
}

#[test]
fn a_users_technique_is_compared_as_ours_are() {
    let options = compare::CompareOptions {
        catalogue: catalogue(),
        techniques: vec!["variance".to_owned()],
        runs: None,
        ..compare::CompareOptions::quick()
    };
    let scene = umbrage::scenes::by_argument("cubes").expect("a built-in scene");
    let input = SceneInput::new(scene, "");
    let mut backends = Backends::from_backends(vec![Box::new(Cpu::new())]);
    let sink = &mut |_: &_, _: &_| Ok(());
    let compared = compare::compare(&[input], &options, &mut backends, sink, &|_| ());
    let compared = compared.expect("valid");
    // Without casters, the technique is lit where its receivers face the light.
    assert!(compared.faults().is_empty(), "{:?}", compared.faults());
    let rows = &compared.scenes[0].rows;
    assert!(rows.iter().all(|row| row.technique == "variance"));
    let rmse = rows[0]
        .measured_figures()
        .and_then(|measured| measured.rmse());
    assert!(rmse.is_some_and(|rmse| rmse < 0.3), "{rows:?}");
    let unknown = compare::CompareOptions {
        catalogue: Catalogue::built_in(),
        ..options
    };
    let none = compare::compare(&[], &unknown, &mut backends, sink, &|_| ());
    let why = none.expect_err("not built in").to_string();
    assert!(why.contains("variance") && why.contains("pcf"), "{why}");
}

#[test]
fn a_users_technique_is_judged_as_ours_are() {
    let options = stability::StabilityOptions {
        catalogue: catalogue(),
        rows: vec!["thin-plate".to_owned()],
        techniques: vec!["variance".to_owned()],
        ..stability::StabilityOptions::quick()
    };
    let mut backends = Backends::from_backends(vec![Box::new(Cpu::new())]);
    let judged = stability::run(&options, &mut backends, &mut |_| ()).expect("valid");
    let cells = &judged.cases[0].cells;
    assert!(cells.iter().any(|cell| cell.technique == "variance"));
    let windows = stability::windows(&options, &mut backends, &mut |_| ()).expect("valid");
    let bases: Vec<stability::Base> = windows.iter().map(|window| window.base).collect();
    assert_eq!(bases, [stability::Base::Own, stability::Base::Bare]);
    assert!(windows.iter().all(|window| window.technique == "variance"));
}

/// The technique's maps are fitted in both ways in motion, and both its shimmer and its error are
/// evaluated.
#[test]
fn a_users_technique_moves_as_ours_do() {
    let options = stability::StabilityOptions {
        catalogue: catalogue(),
        rows: vec!["hills-pan".to_owned(), "hills-pan-stable".to_owned()],
        techniques: vec!["variance".to_owned()],
        ..stability::StabilityOptions::quick()
    };
    let mut backends = Backends::from_backends(vec![Box::new(Cpu::new())]);
    let judged = stability::run(&options, &mut backends, &mut |_| ()).expect("valid");
    assert_eq!(judged.cases.len(), 2);
    for case in &judged.cases {
        for cell in &case.cells {
            let figures = cell.judgements().iter().filter_map(|j| j.figure);
            assert_eq!(figures.count(), 2, "{}: {cell:?}", case.case);
        }
        let in_stable_fit = case.cells.iter().filter(|c| c.settings.contains("stable"));
        let expected = if case.fit.is_empty() {
            0
        } else {
            case.cells.len()
        };
        assert!(!case.cells.is_empty());
        assert_eq!(in_stable_fit.count(), expected, "{}", case.case);
    }
}

/// The planner evaluates it, among all techniques, on maps of all sizes.
#[test]
fn a_users_technique_is_planned_as_ours_are() {
    let scene = umbrage::scenes::by_argument("cubes").expect("a built-in scene");
    let options = plan::PlanOptions {
        catalogue: catalogue(),
        samples: 512,
        // Large enough for maps to cost less than a ray for each pixel.
        size: Some(UVec2::new(384, 256)),
        // Redraw in every frame: then smaller maps cost less, and maps cost less than volumes.
        motion: plan::motion::FrameMotion::AllMoves,
        ..plan::PlanOptions::default()
    };
    let tried = std::sync::Mutex::new(Vec::new());
    let on_step = |step: plan::Step<'_>| {
        if let plan::Step::Trying(name, _) = step {
            tried.lock().expect("no panic").push(name.to_owned());
        }
    };
    let bounds = plan::Bounds::error(0.02);
    plan::plan(&scene, &bounds, &options, &on_step).expect("valid");
    let tried = tried.into_inner().expect("no panic");
    assert!(tried.iter().any(|name| name == "variance"), "{tried:?}");
}

#[test]
fn a_users_preset_is_toml() {
    let technique = Variance {
        radius: 3,
        ..Variance::default()
    };
    let text = umbrage::techniques::TechniquePreset::from(technique)
        .to_toml()
        .expect("numbers");
    let preset = catalogue().preset_from_toml(&text).expect("as written");
    assert_eq!(preset.get(), Some(&technique), "{text}");
    assert!(Catalogue::built_in().preset_from_toml(&text).is_err());
}
