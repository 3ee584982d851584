//! Tests of shaded images.

use crate::stage::{bits, execute_recipe, geometry, recipe, same_on_all_backends, view};
use std::sync::Arc;
use umbrage_core::{
    Backend, Faces, Kernel, Module, NO_TRIANGLE, Recipe, Shade, ShadeKernel, Source, Span, View,
};
use umbrage_cpu::Cpu;

/// Shading whose colours encode the pixel's position, triangle and visibility.
#[derive(Clone, Copy, Debug)]
struct Telling;

impl Kernel for Telling {
    fn modules(&self) -> Vec<Module> {
        Vec::new()
    }
}

impl ShadeKernel for Telling {
    fn shade(&self, span: &Span<'_>, visibility: &[f32], out: &mut [[f32; 4]]) {
        for (i, out) in out.iter_mut().enumerate() {
            *out = [
                span.x[i],
                span.ny[i],
                span.triangle[i] as f32,
                visibility[i],
            ];
        }
    }
}

const BACKGROUND: [f32; 4] = [0.1, 0.2, 0.3, 0.4];

fn shading() -> Recipe {
    let shade = Shade {
        kernel: Arc::new(Telling),
        tables: Vec::new(),
        background: BACKGROUND,
    };
    Recipe {
        shade: Some(shade),
        ..recipe()
    }
}

#[test]
fn every_pixel_that_shows_a_triangle_is_coloured() {
    let shadows = same_on_all_backends(&shading());
    let picture = shadows.picture.unwrap();
    let receivers = shadows.receivers.unwrap();
    let mut lit = [0; 2];
    for (i, color) in picture.iter().enumerate() {
        let id = receivers.triangle[i];
        if id == NO_TRIANGLE {
            assert_eq!(*color, BACKGROUND);
            continue;
        }
        assert_eq!(
            *color,
            [receivers.x[i], receivers.ny[i], id as f32, shadows.mask[i]]
        );
        lit[usize::from(color[3] == 1.0)] += 1;
    }
    assert!(
        lit.iter().all(|&n| n > 50) && picture.contains(&BACKGROUND),
        "{lit:?}"
    );
    let sheet = receivers
        .receives
        .iter()
        .zip(&receivers.triangle)
        .zip(&picture);
    let sheet: Vec<f32> = sheet
        .filter(|((r, t), _)| !**r && **t != NO_TRIANGLE)
        .map(|(_, c)| c[3])
        .collect();
    assert!(
        !sheet.is_empty() && sheet.iter().all(|&v| v == 1.0),
        "pixels that don't receive are lit"
    );
}

#[test]
fn without_shading_there_is_no_picture() {
    assert!(execute_recipe(&mut Cpu::new(), &recipe()).picture.is_none());
}

#[test]
fn replayed_shading_gives_what_the_whole_gave() {
    let recipe = shading();
    let view = view();
    let mut cpu = Cpu::new();
    let whole = cpu.render(&view, &recipe).unwrap();
    let expected = whole.picture.unwrap();
    let picture = cpu.replay_shade(&view, &recipe, &whole.mask).unwrap();
    assert_eq!(bits(picture.as_flattened()), bits(expected.as_flattened()));
    let dark = cpu
        .replay_shade(&view, &recipe, &vec![0.0; whole.mask.len()])
        .unwrap();
    assert_ne!(bits(dark.as_flattened()), bits(expected.as_flattened()));
    assert!(cpu.replay_shade(&view, &recipe, &whole.mask[1..]).is_err());
    assert!(
        cpu.replay_shade(&view, &crate::stage::recipe(), &whole.mask)
            .is_err()
    );
}

#[test]
fn faces_alone_need_no_geometry() {
    let mut recipe = shading();
    let mut cpu = Cpu::new();
    let receivers = cpu.receivers(view().camera, &geometry()).unwrap();
    recipe.casts[0].source = Source::Faces(Arc::new(Faces::default()));
    let view = View {
        geometry: None,
        ..view()
    };
    let shadows = cpu
        .render(&view.with_receivers(&receivers), &recipe)
        .unwrap();
    assert!(
        shadows.images[0].texels.iter().all(|&z| z == 1.0),
        "no faces, no depth"
    );
}
