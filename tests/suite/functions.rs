//! Test 1 of twins: both halves of twin functions on the same inputs.

use std::thread;
use umbrage_core::{
    Module, Twin, bvh, cut_out, displacement, hashed_alpha, light_sample, math, resolve,
};
use umbrage_tests::{
    adapter::{device, open_with},
    driver_model::DriverModel,
    gpu::gpu,
    twins::{Fault, check, check_under, difference, draw, mutants},
};

fn all() -> Vec<Twin> {
    let core = [
        math::TWINS,
        resolve::TWINS,
        bvh::TWINS,
        light_sample::TWINS,
        displacement::TWINS,
        cut_out::TWINS,
        hashed_alpha::TWINS,
    ]
    .concat();
    core.into_iter()
        .chain(umbrage_techniques::twins().copied())
        .collect()
}

/// Tests all twins on the pinned driver, elsewhere those that decide.
#[test]
fn both_halves_give_the_same_bits() {
    let promised = gpu().promises_bits();
    let faults: Vec<String> = all()
        .iter()
        .filter(|twin| promised || decides(twin))
        .filter_map(|t| check(device(), t, &draw(t)).err())
        .map(|e| e.to_string())
        .collect();
    assert!(
        faults.is_empty(),
        "on {}:\n{}",
        device().adapter,
        faults.join("\n")
    );
}

/// Modules whose functions decide whether a point is lit, for `none`, `traced`, `exact` and `soft`.
const DECIDING: [&str; 6] = [
    "math",
    "resolve",
    "ray_triangle",
    "light_sample",
    "facing",
    "cut_out",
];

fn decides(twin: &Twin) -> bool {
    DECIDING.contains(&twin.module.name) || twin.name == "height_over_plane"
}

/// Drivers may fuse products with sums, and return inexact quotients and roots. Deciding functions
/// stay bit-equal, and some others don't.
#[test]
fn what_decides_gives_the_same_bits_on_every_driver() {
    let promised = gpu().promises_bits();
    for model in [DriverModel::Fused, DriverModel::Inaccurate] {
        let descriptor = wgpu::DeviceDescriptor {
            required_features: model.features(),
            ..wgpu::DeviceDescriptor::default()
        };
        let device = match open_with(&descriptor) {
            Ok(device) => device,
            // Lavapipe has 64-bit numbers; Metal doesn't.
            Err(why) if !promised => {
                println!("{model:?} can't be modelled on this device: {why}");
                continue;
            }
            Err(why) => panic!("{model:?}: {why}"),
        };
        let differs = |twin: &Twin| check_under(&device, twin, &draw(twin), Some(model)).err();
        let (deciding, others): (Vec<Twin>, Vec<Twin>) = all().into_iter().partition(decides);
        let faults: Vec<String> = deciding
            .iter()
            .filter_map(|twin| Some(format!("{}: {}", twin.module.name, differs(twin)?)))
            .collect();
        assert!(faults.is_empty(), "{model:?}:\n{}", faults.join("\n"));
        let changed = others.iter().filter(|twin| differs(twin).is_some()).count();
        println!(
            "{model:?}: {} twins that decide are equal, {changed} of {} others differ",
            deciding.len(),
            others.len()
        );
        assert!(changed > 0, "the model changes nothing");
    }
}

#[test]
fn every_changed_operator_is_caught() {
    let twins = all();
    // Interleave mutants over threads, since their numbers differ widely.
    let caught: Vec<Caught> = thread::scope(|scope| {
        let check = |first: usize| {
            let twins = &twins;
            scope.spawn(move || {
                let of_thread = twins.iter().skip(first).step_by(MUTANT_THREADS);
                let mut caught = Caught::default();
                of_thread.for_each(|twin| caught.check_mutants(twin, twins));
                caught
            })
        };
        let threads: Vec<_> = (0..MUTANT_THREADS).map(check).collect();
        let join = |thread: thread::ScopedJoinHandle<'_, Caught>| thread.join().expect("no panic");
        threads.into_iter().map(join).collect()
    });
    let missed: Vec<String> = caught.iter().flat_map(|c| c.missed.clone()).collect();
    assert!(missed.is_empty(), "not caught:\n{}", missed.join("\n"));
    let differing: usize = caught.iter().map(|c| c.differing).sum();
    assert!(differing > 60, "only {differing} mutants compiled");
}

const MUTANT_THREADS: usize = 2;

/// Results of mutants.
#[derive(Default)]
struct Caught {
    /// Number of mutants that compiled and changed bits.
    differing: usize,
    /// Mutants that were not detected.
    missed: Vec<String>,
}

impl Caught {
    fn check_mutants(&mut self, twin: &Twin, all: &[Twin]) {
        let inputs = draw(twin);
        let in_module = all.iter().filter(|t| t.module.name == twin.module.name);
        let others: Vec<&str> = in_module.map(|t| t.name).collect();
        for (mutant, line) in mutants(twin, &others) {
            // Corrections of quotients and roots only matter on a device with inexact ones.
            let verdict = check(device(), &mutant, &inputs).and_then(|_| {
                check_under(device(), &mutant, &inputs, Some(DriverModel::Inaccurate))
            });
            match verdict {
                Err(Fault::Differs { .. }) => self.differing += 1,
                // Mutants that don't compile (a matrix column plus a scalar) count as detected.
                Err(Fault::Wgsl { .. }) => {}
                verdict => self
                    .missed
                    .push(format!("{}: {line} ({verdict:?})", twin.name)),
            }
        }
    }
}

fn spoilt_twin(text: &'static str) -> Twin {
    let dot3 = math::TWINS
        .iter()
        .find(|t| t.name == "dot3")
        .expect("math has dot3");
    Twin {
        module: Module { name: "math", text },
        ..*dot3
    }
}

#[test]
fn a_wrong_signature_is_caught() {
    for text in [
        "fn dot3(a: vec3f, b: vec4f) -> f32 { return a.x + b.x; }",
        "fn dot3(a: vec3f, b: vec3f) -> vec3f { return a + b; }",
        "fn dot3(a: vec3f) -> f32 { return a.x; }",
        "fn dot4(a: vec3f, b: vec3f) -> f32 { return a.x + b.x; }",
    ] {
        let twin = spoilt_twin(text);
        let verdict = check(device(), &twin, &draw(&twin));
        assert!(
            matches!(verdict, Err(Fault::Signature { .. })),
            "{verdict:?} for {text}"
        );
    }
}

#[test]
fn wgsl_that_does_not_compile_is_caught() {
    let twin = spoilt_twin("fn dot3(a: vec3f, b: vec3f) -> f32 { return nonsense; }");
    let verdict = check(device(), &twin, &draw(&twin));
    assert!(matches!(verdict, Err(Fault::Wgsl { .. })), "{verdict:?}");
}

#[test]
fn constant_results_prove_nothing_and_are_refused() {
    let twin = Twin {
        call: |_| vec![0],
        ..spoilt_twin("fn dot3(a: vec3f, b: vec3f) -> f32 { return 0.0; }")
    };
    let verdict = check(device(), &twin, &draw(&twin));
    assert!(matches!(verdict, Err(Fault::Dull { .. })), "{verdict:?}");
}

#[test]
fn ulps_count_neighbouring_floats() {
    let next = |x: f32| x.to_bits() + 1;
    assert_eq!(difference(1.0_f32.to_bits(), next(1.0), true), 1);
    assert_eq!(difference((-1.0_f32).to_bits(), next(-1.0), true), 1);
    assert_eq!(difference(0.0_f32.to_bits(), (-0.0_f32).to_bits(), true), 0);
    assert_eq!(
        difference(1, 1 << 31 | 1, true),
        2,
        "the least floats next to zero"
    );
    assert_eq!(
        difference(f32::NAN.to_bits(), f32::NAN.to_bits() + 3, true),
        0
    );
    assert_eq!(
        difference(f32::NAN.to_bits(), f32::INFINITY.to_bits(), true),
        u64::MAX
    );
    assert_eq!(difference(5, 7, false), 2);
}
