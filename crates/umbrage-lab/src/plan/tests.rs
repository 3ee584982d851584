//! Plans of scenes whose best technique is known.

use super::*;

fn planned(name: &str, bounds: &Bounds) -> Plan {
    let scene = umbrage_scenes::by_argument(name).expect("built in");
    plan(&scene, bounds, &Options::default(), &|_| {}).expect("can be planned")
}

#[test]
fn where_nothing_casts_there_is_no_shadow_to_make() {
    for name in ["no-casters", "only-sky", "no-receivers"] {
        let plan = planned(name, &Bounds::error(0.01));
        assert_eq!(plan.chosen.as_ref().map(|c| c.technique.as_str()), Some("none"), "{name}");
    }
}

#[test]
fn the_same_seed_gives_the_same_plan() {
    let untimed = |mut plan: Plan| {
        (plan.sampled.looking, plan.sampled.trying) = (0.0, 0.0);
        plan
    };
    let [a, b] = [(); 2].map(|()| untimed(planned("cubes", &Bounds::error(0.08))));
    assert_eq!(a, b);
}
