//! Components of a town's facades. A panel spans one window of one storey. Its front is at z = 0
//! and faces +z.

use super::parts::{box_at, crease_mesh, merge_parts, sheet, stick, transform_mesh, translation};
use crate::primitives::{block, lathe, pillar, prism, quad};
use umbrage_core::Mesh;
use umbrage_core::glam::{Affine3A, Quat, Vec3};

/// Width and height of a panel, and the walls' thickness, metres.
pub(super) const PANEL: f32 = 2.7;
pub(super) const STOREY: f32 = 3.2;
pub(super) const THICKNESS: f32 = 0.32;

/// A hole in a panel, metres: half its width, its sill and its lintel above the panel's foot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Opening {
    half: f32,
    sill: f32,
    lintel: f32,
}

pub(super) const WINDOW: Opening = Opening {
    half: 0.62,
    sill: 0.9,
    lintel: 2.65,
};
pub(super) const SHOP: Opening = Opening {
    half: 1.05,
    sill: 0.25,
    lintel: 2.7,
};

/// Returns the wall around an opening.
pub(super) fn panel(opening: &Opening) -> Mesh {
    let slab = |x: [f32; 2], y: [f32; 2]| {
        let low = Vec3::new(x[0], y[0], -THICKNESS);
        block(low, [x[1], y[1], 0.0])
    };
    let half = 0.5 * PANEL;
    let adjacent = [opening.sill, opening.lintel];
    let parts = [
        slab([-half, half], [0.0, opening.sill]),
        slab([-half, half], [opening.lintel, STOREY]),
        slab([-half, -opening.half], adjacent),
        slab([opening.half, half], adjacent),
    ];
    merge_parts("panel", parts)
}

/// Returns sill, lintel, frame and bars of a window, and the moulding between storeys.
pub(super) fn trim(opening: &Opening) -> Mesh {
    let wide = opening.half + 0.13;
    let middle = 0.5 * (opening.sill + opening.lintel);
    let tall = 0.5 * (opening.lintel - opening.sill);
    // Make horizontal bars thinner than upright ones, so that no faces coincide where they cross.
    let upright = |x: f32, half: f32| box_at([x, middle, -0.19], [half, tall, 0.03]);
    let level = |y: f32, half: f32| box_at([0.0, y, -0.19], [opening.half, half, 0.025]);
    let mut parts = vec![
        box_at([0.0, opening.sill - 0.04, 0.04], [wide, 0.04, 0.1]),
        box_at([0.0, opening.lintel + 0.09, 0.02], [wide, 0.09, 0.06]),
        box_at(
            [0.0, opening.lintel + 0.21, 0.05],
            [wide + 0.08, 0.03, 0.11],
        ),
        box_at([0.0, STOREY - 0.07, 0.02], [0.5 * PANEL, 0.07, 0.06]),
        upright(0.0, 0.035),
        level(opening.sill + 0.03, 0.03),
        level(opening.lintel - 0.03, 0.03),
    ];
    for part in [-1.0, 1.0] {
        parts.push(upright(part * (opening.half - 0.03), 0.03));
        parts.push(level(middle + 0.36 * tall * part, 0.018));
    }
    merge_parts("trim", parts)
}

pub(super) fn pane(opening: &Opening) -> Mesh {
    let corner = |x: f32, y: f32| Vec3::new(x, y, -0.2);
    quad([
        corner(-opening.half, opening.sill),
        corner(opening.half, opening.sill),
        corner(opening.half, opening.lintel),
        corner(-opening.half, opening.lintel),
    ])
}

/// Returns a window's two shutters, open, with their slats.
pub(super) fn shutters() -> Mesh {
    let mut parts = Vec::new();
    let tall = 0.5 * (WINDOW.lintel - WINDOW.sill);
    let middle = WINDOW.sill + tall;
    for side in [-1.0, 1.0] {
        let x = side * (WINDOW.half + 0.31);
        for edge in [-0.26, 0.26] {
            let place = Vec3::new(x + edge, middle, 0.05);
            parts.push(box_at(place, [0.035, tall, 0.02]));
        }
        for i in 0..16 {
            let y = WINDOW.sill + 2.0 * tall * (i as f32 + 0.5) / 16.0;
            let slat = box_at(Vec3::ZERO, [0.23, 0.04, 0.006]);
            let tilt = Affine3A::from_rotation_x(0.6);
            parts.push(transform_mesh(slat, translation(x, y, 0.05) * tilt));
        }
    }
    merge_parts("shutters", parts)
}

/// Returns a balcony before a window: slab, brackets, railing.
pub(super) fn balcony() -> Mesh {
    const HALF: f32 = 1.15;
    const DEPTH: f32 = 0.85;
    const RAIL: f32 = 1.0;
    let mut parts = vec![box_at([0.0, -0.06, 0.5 * DEPTH], [HALF, 0.06, 0.5 * DEPTH])];
    let mut rail = |from: [f32; 2], to: [f32; 2], bars: u32| {
        let foot = Vec3::new(from[0], 0.0, from[1]);
        let end = Vec3::new(to[0], 0.0, to[1]);
        for height in [0.08, RAIL] {
            let up = height * Vec3::Y;
            parts.push(stick(foot + up, end + up, 0.022));
        }
        for i in 0..=bars {
            let place = foot.lerp(end, i as f32 / bars as f32);
            parts.push(stick(place, place + RAIL * Vec3::Y, 0.009));
        }
    };
    let side = HALF - 0.05;
    let front = DEPTH - 0.05;
    rail([-side, front], [side, front], 20);
    rail([-side, 0.0], [-side, front], 7);
    rail([side, 0.0], [side, front], 7);
    for x in [-0.8, 0.8] {
        let wall = Vec3::new(x, -0.55, 0.0);
        parts.push(stick(wall, [x, -0.1, 0.7], 0.04));
    }
    merge_parts("balcony", parts)
}

/// Returns the cornice over one panel.
pub(super) fn cornice() -> Mesh {
    let half = 0.5 * PANEL;
    let mut parts = vec![
        box_at([0.0, 0.1, 0.05], [half, 0.1, 0.15]),
        box_at([0.0, 0.42, 0.12], [half, 0.07, 0.42]),
        box_at([0.0, 0.53, 0.1], [half, 0.04, 0.5]),
    ];
    for i in 0..6 {
        let x = half * (2.0 * (i as f32 + 0.5) / 6.0 - 1.0);
        parts.push(box_at([x, 0.27, 0.2], [0.09, 0.08, 0.2]));
    }
    merge_parts("cornice", parts)
}

/// Returns an awning over a shop: cloth on two arms, with a scalloped edge.
pub(super) fn awning() -> Mesh {
    const DEPTH: f32 = 1.7;
    let half = 0.47 * PANEL;
    let cloth = sheet([32, 10], |u, v| {
        let x = half * (2.0 * u - 1.0);
        let sag = 0.08 * v * (1.0 - v);
        Vec3::new(x, 2.95 - 0.6 * v - sag, 0.05 + DEPTH * v)
    });
    let edge = sheet([32, 4], |u, v| {
        let x = half * (2.0 * u - 1.0);
        let scallop = (8.0 * u).fract() - 0.5;
        let drop = 0.26 - 0.4 * scallop * scallop;
        Vec3::new(x, 2.35 - drop * v, 0.05 + DEPTH)
    });
    let arms = [-half, half].map(|x| {
        let out = Vec3::new(x, 2.36, 0.03 + DEPTH);
        stick([x, 2.3, 0.0], out, 0.015)
    });
    merge_parts("awning", [cloth, edge].into_iter().chain(arms))
}

/// Returns a chimney with its pots.
pub(super) fn chimney() -> Mesh {
    let stack = block([-0.3, 0.0, -0.8], [0.3, 1.5, 0.8]);
    let crown = block([-0.36, 1.5, -0.86], [0.36, 1.62, 0.86]);
    let outline = [
        (0.0, 0.0),
        (0.16, 0.0),
        (0.12, 0.4),
        (0.15, 0.5),
        (0.0, 0.5),
    ];
    let pots =
        [-0.5, 0.0, 0.5].map(|z| transform_mesh(lathe(&outline, 14), translation(0.0, 1.62, z)));
    merge_parts("chimney", [stack, crown].into_iter().chain(pots))
}

/// Returns the paint, the glass and the rubber of a car that is 4.2 m long in z.
pub(super) fn car() -> [Mesh; 3] {
    let outline = [
        (-2.1, 0.28),
        (2.1, 0.28),
        (2.12, 0.62),
        (1.95, 0.82),
        (1.05, 0.95),
        (0.45, 1.42),
        (-1.15, 1.45),
        (-1.85, 0.98),
        (-2.1, 0.92),
    ];
    let cabin = [(0.92, 0.97), (0.42, 1.36), (-1.1, 1.39), (-1.7, 1.0)];
    let lengthwise = Affine3A::from_rotation_y(std::f32::consts::FRAC_PI_2);
    let paint = crease_mesh(&prism(&outline, 0.86, -0.86));
    let glass = crease_mesh(&prism(&cabin, 0.875, -0.875));
    let upright = Affine3A::from_quat(Quat::from_rotation_x(std::f32::consts::FRAC_PI_2));
    let wheel = transform_mesh(crease_mesh(&pillar(0.33, 0.22, 28)), upright);
    let mut wheels = Vec::new();
    for x in [-1.3, 1.3] {
        for z in [-0.9, 0.68] {
            wheels.push(transform_mesh(wheel.clone(), translation(x, 0.33, z)));
        }
    }
    [paint, glass, merge_parts("wheels", wheels)].map(|part| transform_mesh(part, lengthwise))
}
