//! Backends other than the first: they must agree if they support a recipe, and must not change any
//! figure.

use super::*;

/// Runs one moving case with one technique and a second backend that errs in its `k`th rendering,
/// counted from 1; 0 means never.
///
/// Returns the disagreement over all settings, the faults, and the number of the second backend's
/// renderings. Settings run on several threads, so the setting of the `k`th rendering varies.
fn run_with_faulty_backend(k: u32) -> (Option<u64>, Vec<String>, u32) {
    let options = StabilityOptions {
        rows: vec!["fence-pan".to_owned()],
        techniques: vec!["traced".to_owned()],
        ..small()
    };
    let rendered = Arc::new(AtomicU32::new(0));
    let count = rendered.clone();
    let faulty = FaultyBackend::new(move |shadows: &mut Shadows| {
        if count.fetch_add(1, Ordering::Relaxed) + 1 == k {
            darken_one(shadows);
        }
    });
    let mut backends = Backends::from_backends(vec![Box::new(Cpu::new()), Box::new(faulty)]);
    let Stability { cases, faults, .. } = run(&options, &mut backends, &mut |_| {}).expect("runs");
    let disagreeing = cases[0].cells.iter().map(|cell| cell.disagreeing);
    (
        disagreeing.fold(None, all_backends::sum),
        faults,
        rendered.load(Ordering::Relaxed),
    )
}

#[test]
fn moving_rows_run_their_first_and_last_frame_on_every_backend() {
    let (disagreeing, faults, rendered) = run_with_faulty_backend(0);
    let settings = rendered / 2;
    assert!(
        disagreeing == Some(0) && faults.is_empty() && rendered == 2 * settings && settings > 0,
        "{faults:?}"
    );
    for k in 1..=rendered {
        let (disagreeing, faults, _) = run_with_faulty_backend(k);
        assert!(
            disagreeing == Some(1) && faults.len() == 1,
            "rendering {k} of {rendered}: {faults:?}"
        );
        assert!(
            faults[0].contains("backends differ on 1 decided pixels"),
            "{faults:?}"
        );
    }
}

/// A backend for which every map is too large.
#[derive(Debug)]
struct Tiny;

impl Backend for Tiny {
    fn name(&self) -> &str {
        "tiny"
    }

    fn kind(&self) -> &'static str {
        "tiny"
    }

    fn render(&mut self, _: &View<'_>, _: &Recipe) -> Result<Shadows, BackendError> {
        Err(Invalid::new(
            "map",
            "is larger than this backend supports",
            "make it smaller",
        )
        .into())
    }
}

/// A backend that supports nothing changes no figure of the first one, and doesn't prevent the
/// check of the others.
#[test]
fn backends_that_serve_nothing_are_left_out() {
    let options = StabilityOptions {
        rows: vec!["fence-pan".to_owned(), "thin-plate".to_owned()],
        techniques: vec!["hard".to_owned()],
        ..small()
    };
    let cpu = || Box::new(Cpu::new()) as Box<dyn Backend + Send>;
    let faulty = || Box::new(FaultyBackend::new(darken_one)) as Box<dyn Backend + Send>;
    let cells = |own_backends: Vec<Box<dyn Backend + Send>>| -> Vec<Cell> {
        let mut backends = Backends::from_backends(own_backends);
        let stability = run(&options, &mut backends, &mut |_| {}).expect("runs");
        stability.cases.into_iter().flat_map(|c| c.cells).collect()
    };
    let alone = cells(vec![cpu()]);
    assert!(
        alone.iter().filter(|cell| cell.figure().is_some()).count() > 2,
        "{alone:?}"
    );
    let outcomes = |cells: &[Cell]| {
        cells
            .iter()
            .map(|c| (c.outcome.clone(), c.disagreeing))
            .collect::<Vec<_>>()
    };
    assert_eq!(
        outcomes(&cells(vec![cpu(), Box::new(Tiny)])),
        outcomes(&alone)
    );
    let checked = cells(vec![cpu(), Box::new(Tiny), faulty()]);
    for (cell, alone) in checked.iter().zip(&alone) {
        assert_eq!(cell.figure(), alone.figure());
        assert_eq!(
            cell.disagreeing.is_some_and(|n| n > 0),
            cell.figure().is_some(),
            "{cell:?}"
        );
    }
    // Figures are the first backend's: without it there are none.
    assert!(
        cells(vec![Box::new(Tiny), cpu()])
            .iter()
            .all(|cell| cell.figure().is_none())
    );
}
