//! Temporary: times the parts of `exact`.
use std::time::Instant;
use umbrage::{Backend, cpu::Cpu, Geometry, ShadowTechnique, View};
fn main() {
    let names: Vec<String> = std::env::args().skip(1).collect();
    for name in &names {
        let scene = umbrage::scenes::by_argument(name).unwrap();
        let geometry = Geometry::bake(&scene).unwrap();
        let camera = scene.cameras[0].resized(umbrage::glam::UVec2::new(1280, 720));
        let mut cpu = Cpu::new();
        let receivers = cpu.receivers(&camera, &geometry).unwrap();
        for light in &scene.lights {
            let view = View::new(&camera, light, &geometry).with_receivers(&receivers);
            let traced = umbrage_techniques::Traced { samples: 1 }.recipe(&view).unwrap();
            let hard = umbrage_techniques::Hard { map: umbrage_techniques::ShadowMap { size: 2048, ..Default::default() } }.recipe(&view).unwrap();
            if std::env::var_os("LOOK").is_some() { let exact = umbrage_techniques::Exact {}.recipe(&view).unwrap(); let mut least = f64::INFINITY; for _ in 0..60 { let t = cpu.render(&view, &exact).unwrap().timings.receive.unwrap().as_secs_f64(); least = least.min(t); } println!("{name} {:.2} ms", least * 1e3); continue; }
            if std::env::var_os("BUILD").is_some() { let mut least = f64::INFINITY; for _ in 0..20 { let fresh = geometry.without_hierarchies(); fresh.caster_bounds(); fresh.bounds(); fresh.max_receiver_extent(); let v = View { geometry: Some(&fresh), ..view }; let start = Instant::now(); umbrage_techniques::Exact {}.recipe(&v).unwrap(); least = least.min(start.elapsed().as_secs_f64()); } println!("{name} built in {:.2} ms", least * 1e3); continue; }
            let mut best = [f64::INFINITY; 5];
            for _ in 0..5 {
                let fresh = geometry.without_hierarchies();
                fresh.caster_bounds();
                fresh.max_receiver_extent();
                let fresh_view = View { geometry: Some(&fresh), ..view };
                let start = Instant::now();
                let exact = umbrage_techniques::Exact {}.recipe(&fresh_view).unwrap();
                let built = start.elapsed().as_secs_f64() * 1e3;
                let ours = cpu.render(&view, &exact).unwrap();
                let rays = cpu.render(&view, &traced).unwrap();
                let map = cpu.render(&view, &hard).unwrap();
                let differ = ours.mask.iter().zip(&rays.mask).filter(|(a, b)| a != b).count();
                if differ > 0 { println!("{differ} DIFFER"); }
                let ms = |d: Option<std::time::Duration>| d.unwrap_or_default().as_secs_f64() * 1e3;
                let now = [built, ms(ours.timings.receive), ms(rays.timings.receive), ms(map.timings.cast), ms(map.timings.receive)];
                for (b, n) in best.iter_mut().zip(now) { *b = b.min(n); }
            }
            let exact = umbrage_techniques::Exact {}.recipe(&view).unwrap();
            let rows: Vec<String> = exact.tables.iter().map(|t| format!("{} {:.1} MB", t.label, t.rows.len() as f64 * 16e-6)).collect();
            let [built, look, rays, cast, map] = best;
            println!("{name} {} {} casters: build {built:.1} + lookup {look:.1}; rays {rays:.1} ({:.1}x); hard {cast:.1} + {map:.1} ({:.2}); {}", light.kind(), geometry.casters().len(), rays / look, (built + look) / (cast + map), rows.join(", "));
        }
    }
}
