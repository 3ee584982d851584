//! Counted work of a hierarchy that the device builds: of its lookups, and of building it. Counts
//! don't depend on the driver, unlike times, so that they also bound the work of graphics cards.
//!
//! Nodes, tests and references are counted on the device. Bytes follow from them, by what the code
//! of the passes reads and writes.

use std::sync::Arc;
use umbrage_core::{
    Backend as _, Geometry, Inputs, Kernel, Module, ReceiveKernel, ShadowTechnique as _, Span,
    UniformBlock, View, glam::UVec2,
};
use umbrage_techniques::{Exact, ExactStructure};
use umbrage_tests::gpu::gpu;

/// Bytes that a lookup reads for a node, for a triangle test (its id and corners), and for each
/// receiver, with the result.
const NODE_BYTES: f64 = 64.0;
const TEST_BYTES: f64 = 52.0;
const RECEIVER_BYTES: f64 = 36.0;

/// Bytes of building for each caster: its corners are written once from its vertices (36) and
/// indices (12), and read by two passes.
const CASTER_BYTES: f64 = 36.0 + 12.0 + 48.0 + 2.0 * 48.0;
/// Bytes of building for each reference: it is written (8) with its key (4). Each of the four passes
/// of the sort reads the key twice and writes a number; three of them read a number, and three write
/// the key. The leaves read the number, the reference and the corners, and write the id.
const REFERENCE_BYTES: f64 = 12.0 + (8.0 + 3.0 + 4.0 + 3.0) * 4.0 + (4.0 + 8.0 + 48.0 + 4.0);
/// Bytes of a node that is built: the node and its box are written, and its parent reads the box.
const BUILT_NODE_BYTES: f64 = 64.0 + 2.0 * 32.0;
/// Bytes of the sort's digit counts for each reference that is allowed: each of its four passes
/// accesses 256 counts of four bytes five times for each 2,048 references.
const ALLOWED_BYTES: f64 = 4.0 * 5.0 * 4.0 * 256.0 / 2048.0;
/// Nodes of all levels for each reference: 1/8 + 1/64 + ...
const NODES_A_REFERENCE: f64 = 1.0 / 7.0;
/// References that are allowed for each caster. A light with a position has up to four more, at most
/// [`MORE_REFERENCES`] in all.
const ALLOWED_REFERENCES: f64 = 2.0;
const MORE_REFERENCES: f64 = 262_144.0;

/// Sides of a block of receivers that a card executes together, pixels.
const BLOCK: [usize; 2] = [8, 4];

/// Frames of the table.
const FRAMES: [&str; 6] = [
    "night-room",
    "dancer",
    "street",
    "nave",
    "valley",
    "leaf-cards",
];
const HEAD: &str = "| frame | tests | worst block | most tests | walked | longest | lockstep walk | bytes a receiver | references | bytes a caster |
|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|";

/// Events that the lookup's WGSL counts.
#[derive(Clone, Copy, Debug)]
enum Count {
    Nodes,
    Tests,
}

/// A kernel whose WGSL returns a count instead of visibility. For receivers that face away from the
/// light it returns minus the number of references of the hierarchy.
#[derive(Clone, Debug)]
struct CountingKernel {
    kernel: Arc<dyn ReceiveKernel>,
    modules: Vec<Module>,
}

impl CountingKernel {
    fn new(kernel: Arc<dyn ReceiveKernel>, count: Count) -> Self {
        let function = match count {
            Count::Nodes => "fn children_at(",
            Count::Tests => "fn meets_caster(",
        };
        let mut modules = kernel.modules();
        let mut edits = 0;
        for module in &mut modules {
            let mut text = module.text.to_owned();
            if let Some(at) = text.find(function) {
                let body = at + text[at..].find("{\n").expect("a body") + 2;
                text.insert_str(body, "    counted += 1.0;\n");
                text.insert_str(0, "var<private> counted: f32;\n");
                edits += 1;
            }
            let result = "return select(0.0, 1.0, is_lit);";
            if text.contains(result) {
                let faces = "dot3(r.normal, d) > 0.0";
                let counted = format!("return select(-f32(table_0[0].z), counted, {faces});");
                text = text.replace(result, &counted);
                edits += 1;
            }
            module.text = text.leak();
        }
        assert_eq!(edits, 2, "the lookup's WGSL has changed");
        Self { kernel, modules }
    }
}

impl Kernel for CountingKernel {
    fn modules(&self) -> Vec<Module> {
        self.modules.clone()
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        self.kernel.uniforms()
    }
}

impl ReceiveKernel for CountingKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        self.kernel.receive(inputs, span, out);
    }

    fn in_compute(&self) -> bool {
        true
    }
}

/// Counts of a frame.
#[derive(Clone, Copy, Debug)]
struct Counts {
    /// Means of a receiver that faces the light.
    nodes: f64,
    tests: f64,
    /// Most nodes and tests of one receiver.
    longest: f32,
    most_tests: f32,
    /// Mean of the tests in the worst block.
    worst_block: f64,
    /// Mean over the blocks of the longest walk.
    lockstep: f64,
    /// References of a caster: present ones, and allowed ones.
    references: f64,
    allowed_references: f64,
}

impl Counts {
    /// Returns the counts of a built-in scene at this size.
    fn of_scene(name: &str, size: UVec2) -> Self {
        let scene = umbrage_scenes::by_argument(name).expect("built in");
        let geometry = Geometry::bake(&scene).expect("valid");
        let camera = scene.cameras[0].with_size(size);
        let view = View::new(&camera, &scene.lights[0], &geometry);
        let technique = Exact {
            structure: ExactStructure::Hierarchy,
        };
        let recipe = technique.recipe(&view).expect("serves the light");
        let of_count = |count| {
            let mut recipe = recipe.clone();
            let kernel = CountingKernel::new(recipe.receive.kernel, count);
            recipe.receive.kernel = Arc::new(kernel);
            let shadows = gpu().render(&view, &recipe).expect("renders");
            let receivers = shadows.receivers.expect("computed");
            let counts = shadows.mask.into_iter().zip(receivers.receives);
            let all = counts.map(|(count, receives)| if receives { count } else { -1.0 });
            all.collect::<Vec<f32>>()
        };
        let nodes = of_count(Count::Nodes);
        let tests = of_count(Count::Tests);
        let references = -f64::from(tests.iter().copied().fold(0.0, f32::min));
        let casters = geometry.casters().len() as f64;
        let more_references = match scene.lights[0].position() {
            Some(_) => f64::min(4.0, MORE_REFERENCES / casters),
            None => 0.0,
        };
        let of_blocks = |counts: &[f32]| blocks(counts, size.x as usize).into_iter();
        Self {
            nodes: mean(&nodes),
            tests: mean(&tests),
            longest: nodes.iter().copied().fold(0.0, f32::max),
            most_tests: tests.iter().copied().fold(0.0, f32::max),
            worst_block: of_blocks(&tests).map(|b| mean(&b)).fold(0.0, f64::max),
            lockstep: mean_of(of_blocks(&nodes).map(|b| greatest(&b)).filter(|&n| n > 0.0)),
            references: references / casters,
            allowed_references: ALLOWED_REFERENCES + more_references,
        }
    }

    /// Returns the bytes that a lookup reads and writes.
    fn bytes(&self) -> f64 {
        NODE_BYTES * self.nodes + TEST_BYTES * self.tests + RECEIVER_BYTES
    }

    /// Returns the bytes that all passes of building read and write, a caster.
    fn building_bytes(&self) -> f64 {
        let node_bytes = NODES_A_REFERENCE * BUILT_NODE_BYTES;
        let present = self.references * (REFERENCE_BYTES + node_bytes);
        CASTER_BYTES + present + self.allowed_references * ALLOWED_BYTES
    }

    fn row(&self, name: &str) -> String {
        format!(
            "| `{name}` | {:.2} | {:.1} | {:.0} | {:.1} | {:.0} | {:.1} | {:.0} | {:.2} | {:.0} |",
            self.tests,
            self.worst_block,
            self.most_tests,
            self.nodes,
            self.longest,
            self.lockstep,
            self.bytes(),
            self.references,
            self.building_bytes()
        )
    }
}

fn mean_of(counts: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut number) = (0.0, 0.0);
    for count in counts {
        sum += count;
        number += 1.0;
    }
    sum / f64::max(number, 1.0)
}

/// Returns the mean of the counts that are not negative.
fn mean(counts: &[f32]) -> f64 {
    mean_of(counts.iter().filter(|&&n| n >= 0.0).map(|&n| f64::from(n)))
}

fn greatest(counts: &[f32]) -> f64 {
    f64::from(counts.iter().copied().fold(0.0, f32::max))
}

/// Returns the counts of each block of an image.
fn blocks(counts: &[f32], width: usize) -> Vec<Vec<f32>> {
    let [wide, high] = BLOCK;
    let across = width.div_ceil(wide);
    let down = (counts.len() / width).div_ceil(high);
    let mut out = vec![Vec::new(); across * down];
    for (i, &count) in counts.iter().enumerate() {
        let [x, y] = [i % width / wide, i / width / high];
        out[y * across + x].push(count);
    }
    out
}

/// The bounds within which building and walks are expected to be cheap on a graphics card
/// (docs/exact.md).
fn check(name: &str, counts: &Counts) {
    assert!(counts.tests > 0.1, "{name}: nothing is counted: {counts:?}");
    assert!(counts.tests <= 6.0, "{name}: tests: {counts:?}");
    assert!(counts.worst_block <= 48.0, "{name}: a block: {counts:?}");
    assert!(counts.longest <= 512.0, "{name}: a walk: {counts:?}");
    assert!(counts.bytes() <= 2000.0, "{name}: bytes: {counts:?}");
    let references = counts.references;
    assert!((1.0..=1.8).contains(&references), "{name}: {counts:?}");
    let building = counts.building_bytes();
    assert!(building <= 512.0, "{name}: {building} bytes: {counts:?}");
}

/// With `UMBRAGE_COUNTS=all`, prints the table of docs/exact.md, which takes three minutes.
#[test]
fn building_and_lookups_stay_within_their_bounds() {
    if std::env::var_os("UMBRAGE_COUNTS").is_none() {
        let counts = Counts::of_scene("night-room", UVec2::new(320, 180));
        return check("night-room", &counts);
    }
    println!("{HEAD}");
    for name in FRAMES {
        let counts = Counts::of_scene(name, UVec2::new(1280, 720));
        println!("{}", counts.row(name));
        check(name, &counts);
    }
}

#[test]
fn blocks_of_an_image_have_their_receivers() {
    let counts: Vec<f32> = (0..10 * 5).map(|i| i as f32).collect();
    let blocks = blocks(&counts, 10);
    let lengths: Vec<usize> = blocks.iter().map(Vec::len).collect();
    assert_eq!(lengths, [32, 8, 8, 2]);
    assert_eq!(blocks[3], [48.0, 49.0]);
}
