use super::*;
use std::fs;

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
