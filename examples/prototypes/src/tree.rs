//! Candidate (b): a hierarchy of eight children a node, built by sorting casters along a curve.
//!
//! Packing a sorted run into nodes: Kamel and Faloutsos 1993, "On Packing R-trees".

use crate::{
    device::{Device, GROUP},
    frame::Frame,
    lookup::{LookUp, answer},
    outcome::{Made, Outcome},
    sort::{SORT_BYTES, Sort, SortBuffers},
};
use anyhow::Result;
use umbrage::{Module, join};

/// Children of a node.
const WIDE: u32 = 8;
/// Bytes of a node's box, and of a caster's corners.
const BOX: f64 = 32.0;
const CORNERS: f64 = 48.0;
/// Bytes to write a caster's corners from three indices and vertices.
const MAKE_CORNERS: f64 = 12.0 + 36.0 + CORNERS;

/// References per caster, at most; and the waste that is tried first and last.
const MOST_REFERENCES: f64 = 1.8;
const FIRST_WASTE: f64 = 0.25;
const LAST_WASTE: f64 = 4096.0;

/// Space of the boxes.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Space {
    /// Rectangles over the light's view, with least depths.
    View,
    /// Boxes in the world, for any rays.
    World,
}

/// Runs the candidate.
pub(crate) fn run(device: &Device, frame: &Frame, space: Space) -> Result<Outcome> {
    // Some casters are divided, and some are on several faces of a point light.
    let capacity = 2 * frame.casters + 1024;
    let mut firsts = [0_u32; 12];
    let mut counts = vec![capacity];
    let mut nodes = 0;
    while counts.len() < 3 || counts[counts.len() - 1] > 1 {
        let count = counts[counts.len() - 1].div_ceil(WIDE);
        firsts[counts.len()] = nodes;
        nodes += count;
        counts.push(count);
    }
    let levels = counts.len() as u32 - 1;
    let place_of = |level: u32| {
        let mut words = vec![frame.casters, capacity, levels, level];
        words.extend(firsts);
        device.uniform("tree", bytemuck::cast_slice(&words))
    };

    let boxes_wgsl = match space {
        Space::View => rects_wgsl(frame)?,
        Space::World => include_str!("../shaders/world_boxes.wgsl").to_owned(),
    };
    let [keys_wgsl, nodes_wgsl, lookup_wgsl] = match space {
        Space::View => [
            include_str!("../shaders/tree_keys.wgsl"),
            include_str!("../shaders/tree_view.wgsl"),
            include_str!("../shaders/view_lookup.wgsl"),
        ],
        Space::World => [
            include_str!("../shaders/world_keys.wgsl"),
            include_str!("../shaders/tree_world.wgsl"),
            include_str!("../shaders/world_lookup.wgsl"),
        ],
    };
    let keys_wgsl = format!("{boxes_wgsl}{keys_wgsl}");
    let common = include_str!("../shaders/tree_blocks.wgsl");
    let blocks_wgsl = format!("{boxes_wgsl}{common}{nodes_wgsl}");
    let entries = ["build_leaves", "build_nodes"];
    let sort = Sort::new(device);

    let buffers = SortBuffers::new(device, capacity);
    let grid = device.uniform("grid", bytemuck::cast_slice(&frame.grid));
    let world = device.uniform("world", bytemuck::cast_slice(&frame.world));
    let references = device.zeros("references", 8 * u64::from(capacity));
    let ids = device.zeros("ids", 4 * u64::from(capacity));
    let head = device.zeros("head", 16);
    let node_bytes = space.node_bytes();
    let node_rows = device.zeros("nodes", node_bytes * u64::from(nodes));
    let node_boxes = device.zeros("boxes", BOX as u64 * u64::from(nodes));
    let places: Vec<_> = (0..levels).map(place_of).collect();
    let named = [
        ("grid", &grid),
        ("world", &world),
        ("made", &places[0]),
        ("corners", &frame.corners),
        ("keys", &buffers.keys[0]),
        ("values", &buffers.values[0]),
        ("head", &head),
        ("references", &references),
    ];
    let groups = frame.casters.div_ceil(GROUP);
    let mut waste = FIRST_WASTE;
    // A renderer adjusts the waste from frame to frame by the number of references that it reads
    // some frames later. Here it settles at once.
    let keys = loop {
        let constants = [("WASTE", waste)];
        let key_entries = ["make_keys", "count_references"];
        let keys = device.program("tree keys", &keys_wgsl, &key_entries, &constants);
        let passes = [device.dispatch(&keys, "make_keys", &named, groups)?];
        device.run(&[&head], &passes)?;
        let wanted = f64::from(frame.casters) + f64::from(device.read(&head)?[1]);
        if wanted <= MOST_REFERENCES * f64::from(frame.casters) || waste >= LAST_WASTE {
            break keys;
        }
        waste *= 2.0;
    };
    let blocks = device.program("tree blocks", &blocks_wgsl, &entries, &[("WASTE", waste)]);
    let mut dispatches = Vec::new();
    dispatches.push(device.dispatch(&keys, "make_keys", &named, groups)?);
    dispatches.push(device.dispatch(&keys, "count_references", &named, 1)?);
    sort.record(device, &buffers, &head, &mut dispatches)?;
    for (level, place) in places.iter().enumerate() {
        let named = [
            ("grid", &grid),
            ("world", &world),
            ("made", place),
            ("corners", &frame.corners),
            ("values", &buffers.values[0]),
            ("head", &head),
            ("nodes", &node_rows),
            ("boxes", &node_boxes),
            ("references", &references),
            ("ids", &ids),
        ];
        let entry = if level == 0 { entries[0] } else { entries[1] };
        let groups = counts[level].div_ceil(64);
        dispatches.push(device.dispatch(&blocks, entry, &named, groups)?);
    }
    let make = device.run(&[&head], &dispatches)?;

    let references_made = device.read(&head)?[0];
    let look_up = LookUp {
        wgsl: frame.ray_wgsl()? + include_str!("../shaders/tree_walk.wgsl") + lookup_wgsl,
        buffers: vec![("tree", &places[0]), ("nodes", &node_rows), ("ids", &ids)],
    };
    let answered = answer(device, frame, &look_up)?;
    let r = f64::from(references_made) / f64::from(frame.casters.max(1));
    let node = node_bytes as f64;
    // A node for eight references, and all levels above it.
    let nodes_each = r / 7.0;
    let leaf_nodes = r / 8.0;
    let made = Made {
        items: r + nodes_each,
        bytes: MAKE_CORNERS
            + CORNERS
            + 16.0 * r
            + SORT_BYTES * r
            + (4.0 + 8.0 + CORNERS + 4.0) * r
            + (node + BOX) * nodes_each
            + BOX * leaf_nodes,
        atomics: 1.0 / 64.0,
        kept: CORNERS + 4.0 * r + node * nodes_each,
        scratch: (16.0 + 8.0) * r + BOX * nodes_each,
    };
    Ok(Outcome {
        candidate: format!("{}, waste {waste}", space.name()),
        answers: answered.answers,
        counted: answered.counted,
        make,
        look_up: answered.time,
        made,
        bytes_walked: node,
        bytes_tested: 4.0 + CORNERS,
        bytes_more: 0.0,
        caster_walks: None,
    })
}

/// Returns the WGSL of casters' rectangles.
pub(crate) fn rects_wgsl(frame: &Frame) -> Result<String> {
    let library: Vec<Module> = frame.list_modules.clone();
    let wanted = |module: &&Module| matches!(module.name, "math" | "touch");
    let modules: Vec<Module> = library.iter().filter(wanted).copied().collect();
    anyhow::ensure!(modules.len() == 2, "the library's modules have changed");
    Ok(join(&modules) + include_str!("../shaders/rects.wgsl"))
}

impl Space {
    fn name(self) -> &'static str {
        match self {
            Self::View => "hierarchy, light's view",
            Self::World => "hierarchy, world",
        }
    }

    fn node_bytes(self) -> u64 {
        match self {
            Self::View => 64,
            Self::World => 80,
        }
    }
}
