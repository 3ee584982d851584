//! Heap allocations of a light set's frames: none at rest, and only those of wgpu's writes while
//! casters move.

use dhat::HeapStats;
use glam::{Mat4, UVec2};
use std::hint::black_box;
use umbrage_tests::{
    adapter::TestDevice,
    foreign,
    light_stage::{Stage, camera, translation_along_x},
};
use umbrage_wgpu::{
    DepthBuffer, LightId, MaskFormat, MaskInputs, MaskReceivers, NormalCoding, SetBudget, SetFrame,
    SetNormals,
};
use wgpu::{BufferUsages, TextureFormat, TextureUsages, TextureView, TextureViewDescriptor};

#[global_allocator]
static ALLOCATIONS: dhat::Alloc = dhat::Alloc;

/// Returns the number of blocks that `work` allocated.
fn blocks(work: impl FnOnce()) -> u64 {
    let before = HeapStats::get().total_blocks;
    work();
    HeapStats::get().total_blocks - before
}

/// Calls `work` with `depth` more stack frames. wgpu captures a backtrace at each write in debug
/// builds, and allocates a list of stack frames whose length grows with the depth.
#[inline(never)]
fn from_below(depth: u32, work: &mut dyn FnMut()) {
    if depth == 0 {
        work();
    } else {
        from_below(depth - 1, black_box(work));
    }
}

fn prepare(stage: &mut Stage) {
    let frame = SetFrame {
        camera: &stage.camera,
        geometry: None,
    };
    stage.set.prepare(&frame).expect("prepares");
}

/// A single test, since the counts are those of the whole program.
#[test]
fn steady_frames_allocate_nothing() {
    let _profiler = dhat::Profiler::builder().testing().build();
    let mut stage = Stage::new(SetBudget::default(), &[-4.0, 0.0, 4.0]);
    let lights = [-4.0, 0.0, 4.0].map(|x| stage.light(x, 1.0));
    stage.frame();
    let d = stage.program.d;
    // Lists have their final capacity after a frame in which a caster moved.
    for x in [0.1, 0.2] {
        let caster = stage.casters[1];
        stage
            .set
            .move_caster(caster, translation_along_x(x))
            .expect("is there");
        stage.frame();
    }
    // The frame after a drawn one polls the device for the encoder's submission.
    prepare(&mut stage);
    let still = blocks(|| prepare(&mut stage));
    assert_eq!(still, 0, "a still frame");
    // Use `black_box`, since the compiler may otherwise remove the block.
    let counted = blocks(|| drop(black_box(Box::new(1_u8))));
    assert_eq!(counted, 1, "the counter counts");
    // wgpu allocates for each write, and sometimes for several. A frame with a moved caster has two
    // writes: its placement, and the matrix of its layer.
    let buffer =
        |usage| umbrage_tests::foreign::buffer(d, usage | BufferUsages::COPY_DST, &[0; 1024]);
    let placements = buffer(BufferUsages::VERTEX);
    let matrices = buffer(BufferUsages::UNIFORM);
    let cameras = buffer(BufferUsages::UNIFORM);
    const FRAMES: u64 = 200;
    let written = blocks(|| {
        for _ in 0..FRAMES {
            from_below(6, &mut || {
                d.queue.write_buffer(&placements, 48, &[1; 48]);
                d.queue.write_buffer(&matrices, 0, &[2; 64]);
            });
        }
    });
    let moved = blocks(|| {
        for i in 0..FRAMES {
            let caster = stage.casters[1];
            let x = 0.1 + 0.1 * (i % 3) as f32;
            stage
                .set
                .move_caster(caster, translation_along_x(x))
                .expect("is there");
            prepare(&mut stage);
            assert_eq!(stage.set.report().redrawn, 1);
        }
    });
    let own = moved as f64 / FRAMES as f64 - written as f64 / FRAMES as f64;
    assert!(
        own < 0.5,
        "a frame in which a caster moved allocated {own:.2} blocks more than wgpu's writes do"
    );

    // Masks of the same lights from the same textures, with different camera matrices.
    let seen = DepthInputs::new(d, stage.program.size());
    let matrices = [0.0, 0.1].map(world_from_clip);
    for matrix in matrices {
        prepare_masks(&mut stage, &seen, matrix, &lights);
    }
    let still = blocks(|| prepare_masks(&mut stage, &seen, matrices[1], &lights));
    assert_eq!(still, 0, "masks of a still frame");
    let written = blocks(|| {
        for _ in 0..FRAMES {
            from_below(6, &mut || d.queue.write_buffer(&cameras, 0, &[1; 80]));
        }
    });
    let turned = blocks(|| {
        for i in 0..FRAMES {
            prepare_masks(&mut stage, &seen, matrices[i as usize % 2], &lights);
        }
    });
    let own = turned as f64 / FRAMES as f64 - written as f64 / FRAMES as f64;
    assert!(
        own < 0.5,
        "masks of a frame in which the camera turned allocated {own:.2} blocks more than wgpu's write does"
    );
}

/// A depth buffer and normals.
struct DepthInputs {
    depth: TextureView,
    normals: TextureView,
    size: UVec2,
}

impl DepthInputs {
    fn new(d: &TestDevice, size: UVec2) -> Self {
        let view = |format| {
            foreign::texture(d, size, format, TextureUsages::TEXTURE_BINDING)
                .create_view(&TextureViewDescriptor::default())
        };
        Self {
            depth: view(TextureFormat::R32Float),
            normals: view(TextureFormat::Rgba16Float),
            size,
        }
    }
}

fn world_from_clip(turn: f32) -> Mat4 {
    let space = camera(turn).space();
    space.clip_from_world().inverse()
}

fn prepare_masks(stage: &mut Stage, seen: &DepthInputs, world_from_clip: Mat4, lights: &[LightId]) {
    let inputs = MaskInputs {
        size: seen.size,
        receivers: MaskReceivers::Depth {
            depth: DepthBuffer {
                depth: &seen.depth,
                world_from_clip,
                empty: 1.0,
            },
            normals: Some(SetNormals {
                texture: &seen.normals,
                coding: NormalCoding::Components,
            }),
        },
        lights,
        format: MaskFormat::Unorm8,
    };
    stage.set.prepare_masks(&inputs).expect("prepares");
}
