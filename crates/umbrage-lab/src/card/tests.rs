use super::*;
use std::fs;
use umbrage_core::Fusing;
use umbrage_plan::cost::CostModel;

fn card(adapter: &str, is_software: bool) -> Card {
    let time = |frame: &str, milliseconds| CardTime {
        frame: frame.to_owned(),
        technique: "hard".to_owned(),
        settings: "1024".to_owned(),
        milliseconds,
        measured_milliseconds: 0.5,
    };
    Card {
        schema: SCHEMA,
        adapter: adapter.to_owned(),
        is_software,
        agreement: Some(CardAgreement {
            same_triangle_pixels: Some(1_234_567),
            differing_bits: [("exact".to_owned(), 3)].into(),
            ..CardAgreement::default()
        }),
        times: Some(vec![time("a 1x1", Some(0.125)), time("b 1x1", None)]),
        ratios: Some([("light set".to_owned(), 1.25)].into()),
        prices: Some(CostModel::SOFTWARE_GPU),
        ..Card::default()
    }
}

#[test]
fn the_page_shows_what_is_there_and_dashes_for_the_rest() {
    let bare = Card {
        adapter: "bare | card".to_owned(),
        ..Card::default()
    };
    let text = page(&[card("fast", false), bare]);
    for line in [
        "| fast | 1,234,567 | -, -, 3, - | - | - |",
        "| bare / card | - | -, -, -, - | - | - |",
        "| technique | a 1x1 | b 1x1 |",
        "| hard (1024) | 0.125 | (0.500) |",
        "| fast | light set | 1.25 |",
    ] {
        assert!(text.contains(line), "no `{line}` in\n{text}");
    }
}

/// Nothing may be fused through `product`. Otherwise the page reports it.
#[test]
fn a_fused_product_is_a_finding() {
    let fusing = |guarded_product| Fusing {
        product_and_sum: true,
        fma: false,
        guarded_product: Some(guarded_product),
    };
    let of = |fusing| Card {
        fusing: Some(fusing),
        ..card("fast", false)
    };
    let text = page(&[of(fusing(false)), of(fusing(true))]);
    for line in [
        "| - | `a * b + c` |\n",
        "| - | `a * b + c`, `product(a, b) + c` |\n",
        "* masks may be wrong: ",
    ] {
        assert_eq!(text.matches(line).count(), 1, "`{line}` in\n{text}");
    }
}

#[test]
fn frames_of_unknown_names_are_an_error() {
    let mut backends = crate::compare::Backends::cpu();
    let error = measure_times(&["no-frame"], &mut backends, &|_| {}).expect_err("unknown");
    assert!(error.to_string().contains("`no-frame`"), "{error}");
    let error = measure_agreement(&mut backends).expect_err("no adapter");
    assert!(error.to_string().contains("adapter"), "{error}");
}

/// A card without later fields is readable. A card of a newer schema is not, though its fields are
/// unknown.
#[test]
fn the_schema_is_read_first() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = dir.path().join("card.json");
    let mut data = serde_json::to_value(card("fast", false)).expect("data");
    data["fusing"] = serde_json::json!({ "product_and_sum": true, "fma": true });
    let agreement = data["agreement"].as_object_mut().expect("fields");
    agreement.remove("compared_pixels").expect("a field");
    fs::write(&file, data.to_string()).expect("there");
    let found = read(&file).expect("a card");
    assert_eq!(found.fusing.and_then(|fusing| fusing.guarded_product), None);
    assert_eq!(found.agreement, card("fast", false).agreement);
    data["schema"] = (SCHEMA + 1).into();
    data["later"] = true.into();
    fs::write(&file, data.to_string()).expect("there");
    let error = read(&file).expect_err("newer").to_string();
    assert!(error.contains("has schema 2"), "{error}");
}

#[test]
fn files_come_back_in_order_and_give_prices() {
    let dir = tempfile::tempdir().expect("a folder");
    let of = |name: &str| dir.path().join(name);
    let cards = [card("fast", false), card("slow", true)];
    for (name, card) in ["z.json", "a.json"].into_iter().zip(&cards) {
        fs::write(of(name), serde_json::to_string(card).expect("data")).expect("there");
    }
    fs::write(of("README.md"), "no card").expect("there");
    assert_eq!(read_all(dir.path()).expect("cards"), cards);
    let prices = read_prices(&of("a.json")).expect("it has prices");
    assert_eq!(
        (&*prices.measured_on, prices.wgpu),
        ("slow", CostModel::SOFTWARE_GPU)
    );
    fs::write(of("bare.json"), "{}").expect("there");
    for broken in ["bare.json", "README.md", "none.json"] {
        assert!(read_prices(&of(broken)).is_err(), "{broken}");
    }
}
