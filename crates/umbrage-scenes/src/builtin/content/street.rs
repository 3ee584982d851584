//! A street of a town: facades with recessed windows, balconies, awnings, lamps, cars, trees, and
//! washing on lines across it. The sun is low and shines towards the camera.

use super::{
    SIZE,
    house::{
        PANEL, SHOP, STOREY, THICKNESS, WINDOW, awning, balcony, car, chimney, cornice, pane,
        panel, shutters, trim,
    },
    parts::{
        box_at, crease_mesh, merge_parts, scaled_placement, sheet, transform_mesh, translation,
        turned_placement, wire,
    },
    plants::{Growth, tree},
    random::Random,
    things::{baluster, street_lamp},
};
use crate::{
    looks::{glossy, matte},
    primitives::{block, grid, lathe},
    stage::Stage,
};
use umbrage_core::glam::{Affine3A, Vec3};
use umbrage_core::{Light, Mesh, Scene};

/// Distances from the centre of the street to the facades and to the kerbs, and the height of the
/// kerbs, metres.
const FACADE: f32 = 6.4;
const KERB: f32 = 3.9;
const RISE: f32 = 0.14;
/// The street's start, behind the camera, and its end, z in metres.
const NEAR: f32 = 14.0;
const FAR: f32 = -120.0;

const PLASTERS: [[f32; 3]; 5] = [
    [0.62, 0.45, 0.28],
    [0.64, 0.57, 0.45],
    [0.55, 0.28, 0.20],
    [0.48, 0.50, 0.50],
    [0.66, 0.53, 0.36],
];
const STONE: [f32; 3] = [0.66, 0.63, 0.57];
const GLASS: [f32; 3] = [0.05, 0.07, 0.09];
const GREEN: [f32; 3] = [0.09, 0.21, 0.16];
const IRON: [f32; 3] = [0.05, 0.05, 0.06];
const SLATE: [f32; 3] = [0.20, 0.21, 0.24];
const ASPHALT: [f32; 3] = [0.30, 0.30, 0.31];
const CLOTHS: [[f32; 3]; 4] = [
    [0.72, 0.70, 0.66],
    [0.60, 0.12, 0.10],
    [0.13, 0.30, 0.52],
    [0.70, 0.52, 0.14],
];

pub(crate) fn street() -> Scene {
    lit_by("street", 0.0)
}

pub(crate) fn street_soft() -> Scene {
    lit_by("street-soft", 4.0_f32.to_radians())
}

fn lit_by(name: &str, angular_diameter: f32) -> Scene {
    let houses = houses();
    let stage = facades(ground(Stage::new(name)), &houses);
    let stage = above_the_street(details(stage, &houses));
    on_the_street(stage)
        .light(Light::Directional {
            direction: Vec3::new(-0.36, -0.50, 0.76),
            angular_diameter,
        })
        .shoot([1.3, 2.3, 8.0], [-1.1, 4.0, -20.0], 58.0, SIZE)
}

/// A house: its front is a grid of panels.
struct House {
    /// -1 on the left, 1 on the right.
    side: f32,
    /// The start of its front, z in metres. The front extends towards -z.
    begin: f32,
    panels: u32,
    storeys: u32,
    plaster: usize,
}

impl House {
    fn width(&self) -> f32 {
        PANEL * self.panels as f32
    }

    fn height(&self) -> f32 {
        RISE + STOREY * self.storeys as f32
    }

    /// Returns the placement of a panel.
    fn place(&self, panel: u32, storey: u32) -> Affine3A {
        let z = self.begin - PANEL * (panel as f32 + 0.5);
        let y = RISE + STOREY * storey as f32;
        let angle = -self.side * std::f32::consts::FRAC_PI_2;
        turned_placement([self.side * FACADE, y, z], angle)
    }

    fn places(&self, storeys: std::ops::Range<u32>) -> impl Iterator<Item = Affine3A> + '_ {
        storeys.flat_map(move |storey| (0..self.panels).map(move |panel| self.place(panel, storey)))
    }

    /// Returns the placement of a unit box behind the front.
    fn body(&self) -> Affine3A {
        const DEPTH: f32 = 9.0;
        let x = self.side * (FACADE + THICKNESS + 0.5 * DEPTH);
        let middle = Vec3::new(x, 0.0, self.begin - 0.5 * self.width());
        scaled_placement(middle, 0.0, [DEPTH, self.height() + 0.3, self.width()])
    }
}

/// Returns the houses: tall ones on the left, lower ones on the right, with gaps for the sun.
fn houses() -> Vec<House> {
    let mut random = Random::new(31);
    let mut out = Vec::new();
    for side in [-1.0, 1.0] {
        let mut begin = NEAR;
        while begin > FAR {
            let storeys = if side < 0.0 {
                random.number_between(4.0, 6.9)
            } else {
                random.number_between(2.0, 3.35)
            };
            let house = House {
                side,
                begin,
                panels: random.number_between(3.0, 6.0) as u32,
                storeys: storeys as u32,
                plaster: random.number_between(0.0, 4.99) as usize,
            };
            begin -= house.width();
            if begin < -9.0 && random.chance(0.4) {
                begin -= 5.0;
            }
            out.push(house);
        }
    }
    out
}

fn ground(stage: Stage) -> Stage {
    let length = 0.5 * (NEAR - FAR) + 10.0;
    let middle = 0.5 * (NEAR + FAR);
    let paving = |side: f32| {
        let [a, b] = [side * KERB, side * (FACADE + 12.0)];
        block(
            [a.min(b), -0.2, middle - length],
            [a.max(b), RISE, middle + length],
        )
    };
    let mut road = grid([KERB, length], [8, 60], |_, _| 0.0);
    for p in &mut road.positions {
        p.y = road_height(p.x);
        p.z += middle;
    }
    stage
        .put(road)
        .look(matte(ASPHALT))
        .put(merge_parts("paving", [paving(-1.0), paving(1.0)]))
        .look(matte([0.52, 0.49, 0.45]))
        .put(markings())
        .look(matte([0.66, 0.65, 0.62]))
        .put(tower())
        .look(matte(STONE))
}

/// Returns a crossing's stripes and a dashed line, painted on the road.
fn markings() -> Mesh {
    let mut parts = Vec::new();
    for i in 0..8 {
        let x = 0.95 * (i as f32 - 3.5);
        let paint = Vec3::new(0.24, 0.004, 1.3);
        parts.push(box_at([x, road_height(x) + 0.002, -2.6], paint));
    }
    for i in 0..30 {
        let z = -7.0 - 4.0 * i as f32;
        let paint = Vec3::new(0.06, 0.004, 0.9);
        parts.push(box_at([0.0, road_height(0.0) + 0.002, z], paint));
    }
    merge_parts("markings", parts)
}

/// Returns the height of the road, metres: its centre is higher than its gutters.
fn road_height(x: f32) -> f32 {
    0.06 - 0.004 * x * x
}

/// Returns a church's tower at the street's end, with openings for its bells.
fn tower() -> Mesh {
    let middle = Vec3::new(-2.0, 0.0, FAR - 16.0);
    let shaft = box_at(middle + 11.0 * Vec3::Y, [4.5, 11.0, 4.5]);
    let crown = box_at(middle + 29.0 * Vec3::Y, [4.9, 0.6, 4.9]);
    let mut parts = vec![shaft, crown];
    for x in [-4.0, -1.4, 1.4, 4.0] {
        for z in [-4.0, 4.0] {
            let foot = middle + Vec3::new(x, 25.0, z);
            parts.push(box_at(foot, [0.5, 3.5, 0.5]));
        }
    }
    let spire = [(0.0, 0.0), (5.6, 0.0), (1.2, 11.0), (0.0, 17.0)];
    let roof = crease_mesh(&lathe(&spire, 8));
    parts.push(transform_mesh(roof, translation(middle.x, 29.6, middle.z)));
    merge_parts("tower", parts)
}

fn facades(mut stage: Stage, houses: &[House]) -> Stage {
    for (i, plaster) in PLASTERS.into_iter().enumerate() {
        let own: Vec<&House> = houses.iter().filter(|house| house.plaster == i).collect();
        let upper = own.iter().flat_map(|house| house.places(1..house.storeys));
        let bodies = own.iter().map(|house| house.body());
        let unit = block([-0.5, 0.0, -0.5], [0.5, 1.0, 0.5]);
        stage = stage
            .put_many(panel(&WINDOW), upper)
            .look(matte(plaster))
            .put_many(unit, bodies)
            .look(matte(plaster));
    }
    let shops: Vec<Affine3A> = houses.iter().flat_map(|house| house.places(0..1)).collect();
    let upper = houses
        .iter()
        .flat_map(|house| house.places(1..house.storeys));
    let upper: Vec<Affine3A> = upper.collect();
    stage
        .put_many(panel(&SHOP), shops.clone())
        .look(matte(STONE))
        .put_many(trim(&SHOP), shops.clone())
        .look(matte(GREEN))
        .put_many(pane(&SHOP), shops)
        .look(glossy(GLASS))
        .put_many(trim(&WINDOW), upper.clone())
        .look(matte(STONE))
        .put_many(pane(&WINDOW), upper)
        .look(glossy(GLASS))
}

fn details(mut stage: Stage, houses: &[House]) -> Stage {
    let mut random = Random::new(77);
    let mut cornices = Vec::new();
    let mut chimneys = Vec::new();
    let mut balconies = Vec::new();
    let mut shuttered = Vec::new();
    let mut awnings = [Vec::new(), Vec::new()];
    for house in houses {
        cornices.extend(house.places(house.storeys..house.storeys + 1));
        let roof = house.height() + 0.2;
        for _ in 0..2 {
            let x = house.side * (FACADE + random.number_between(1.5, 4.0));
            let z = house.begin - house.width() * random.number_between(0.1, 0.9);
            chimneys.push(translation(x, roof, z));
        }
        let has_shutters = random.chance(0.6);
        for place in house.places(1..house.storeys) {
            if random.chance(0.42) {
                balconies.push(place * translation(0.0, 0.4, 0.0));
            } else if has_shutters {
                shuttered.push(place);
            }
        }
        for place in house.places(0..1) {
            if random.chance(0.45) {
                awnings[usize::from(house.panels > 4)].push(place);
            }
        }
    }
    for (places, color) in awnings.into_iter().zip([CLOTHS[1], CLOTHS[2]]) {
        stage = stage.put_many(awning(), places).look(matte(color));
    }
    stage
        .put_many(cornice(), cornices)
        .look(matte(STONE))
        .put_many(chimney(), chimneys)
        .look(matte(PLASTERS[2]))
        .put_many(balcony(), balconies)
        .look(matte(IRON))
        .put_many(shutters(), shuttered)
        .look(matte(GREEN))
}

/// Adds wires across the street, and washing on some of them.
fn above_the_street(mut stage: Stage) -> Stage {
    let mut random = Random::new(5);
    let mut wires = Vec::new();
    let mut washing: [Vec<Mesh>; CLOTHS.len()] = Default::default();
    for i in 0..26 {
        let z = 3.0 - 4.6 * i as f32;
        let y = random.number_between(5.6, 6.3);
        let from = Vec3::new(-FACADE, y + random.unit(), z);
        let to = Vec3::new(FACADE, y, z - random.signed_number(1.5));
        wires.push(wire(from, to, 0.3, 0.012));
        wires.push(wire(from + 0.35 * Vec3::Y, to + 0.3 * Vec3::Y, 0.5, 0.008));
        if i % 3 == 0 {
            continue;
        }
        for piece in 0..7 {
            let t = 0.1 + 0.12 * piece as f32;
            let hung = from.lerp(to, t) - 1.2 * t * (1.0 - t) * Vec3::Y;
            let color = random.number_between(0.0, CLOTHS.len() as f32 - 0.01) as usize;
            let size = [
                random.number_between(0.5, 1.0),
                random.number_between(0.5, 1.2),
            ];
            washing[color].push(cloth(hung, size, random.signed_number(0.2)));
        }
    }
    for (pieces, color) in washing.into_iter().zip(CLOTHS) {
        stage = stage.put(merge_parts("washing", pieces)).look(matte(color));
    }
    stage.put(merge_parts("wires", wires)).look(matte(IRON))
}

/// Returns a cloth of this width and length that hangs from a point of a line along x, blown aside
/// at its foot.
fn cloth(hung: Vec3, size: [f32; 2], blown: f32) -> Mesh {
    sheet([14, 10], |u, v| {
        let (_, wave) = crate::primitives::on_circle(f64::from(2.5 * u + 0.3 * v));
        let z = v * (blown + 0.07 * wave);
        hung + Vec3::new(size[0] * (u - 0.5), -size[1] * v, z)
    })
}

fn on_the_street(mut stage: Stage) -> Stage {
    let mut random = Random::new(12);
    let mut bollards = Vec::new();
    for i in 0..60 {
        let z = 6.0 - 1.8 * i as f32;
        bollards.push(translation(KERB + 0.3, RISE, z));
    }
    let lamps = (0..14).map(|i| {
        let side = if i % 2 == 0 { -1.0 } else { 1.0 };
        translation(side * (KERB + 0.45), RISE, 1.0 - 8.5 * i as f32)
    });
    let mut parked: [Vec<Affine3A>; 3] = Default::default();
    for i in 0..12 {
        let z = -1.5 - 6.4 * i as f32 + random.signed_number(0.6);
        let color = i % parked.len();
        if !random.chance(0.2) {
            let place = Vec3::new(-KERB + 1.05, 0.03, z);
            parked[color].push(turned_placement(place, random.signed_number(0.03)));
        }
    }
    let [paint, glass, wheels] = car();
    let everywhere: Vec<Affine3A> = parked.iter().flatten().copied().collect();
    let paints = [[0.50, 0.06, 0.05], [0.08, 0.16, 0.30], [0.60, 0.60, 0.58]];
    for (places, color) in parked.into_iter().zip(paints) {
        stage = stage.put_many(paint.clone(), places).look(glossy(color));
    }
    let plane_tree = tree(&Growth {
        seed: 3,
        height: 6.0,
        girth: 0.13,
        reach: 2.0,
        bare: 0.42,
        branches: 16,
        leaves: 24,
        leaf: 0.2,
        has_twigs: true,
    });
    let pits = (0..6).map(|i| translation(KERB + 0.9, RISE, -6.0 - 15.0 * i as f32));
    let pits: Vec<Affine3A> = pits.collect();
    stage
        .put_many(glass, everywhere.clone())
        .look(glossy(GLASS))
        .put_many(wheels, everywhere)
        .look(matte(IRON))
        .put_many(baluster(0.95), bollards)
        .look(matte(IRON))
        .put_many(street_lamp(), lamps)
        .look(matte(SLATE))
        .put_many(plane_tree.wood, pits.clone())
        .look(matte([0.24, 0.19, 0.13]))
        .put_many(plane_tree.leaves, pits)
        .look(matte([0.16, 0.30, 0.08]))
}
