use super::*;
use crate::FractureJob;
use crate::job::tests::{sample as job, tetrahedron};
use cullet_geometry::math::unit;
use cullet_geometry::{Sheet, TriMesh};

fn fin() -> Sheet {
    let mesh =
        TriMesh { vertices: vec![Vec3::zeros(), Vec3::x(), Vec3::y()], triangles: vec![[0, 1, 2]] };
    Sheet { mesh, damage_time: vec![1e-5, 2e-5, 0.0], front_speed: vec![0.0, 9.0, 8.0] }
}

fn sample() -> Verdict {
    let fragment = |k: usize| Fragment {
        solid: tetrahedron(),
        hulls: (0..k).map(|h| vec![Vec3::repeat(h as f64); 4 + h]).collect(),
        velocity: Vec3::new(k as f64, 0.0, -1.0),
        spin: Vec3::y(),
        sheet: if k == 1 { fin() } else { Sheet::default() },
    };
    let report = Report {
        solver: "geometric".into(),
        refusal: Some("too thin".into()),
        warnings: vec!["a word".into()],
        ..Report::default()
    }
    .with(STRENGTH_RATIO, "1", 1.0);
    let fragments = vec![fragment(1), fragment(0), fragment(3)];
    let grain = Grain { position: Vec3::x(), velocity: Vec3::y(), volume: 1e-9, size: 1e-3 };
    let debris = vec![grain, Grain { size: 2e-3, ..grain }];
    let reactions = vec![0.5, 0.0];
    let origins = vec![FragmentOrigin::Sampled, FragmentOrigin::Solved, FragmentOrigin::Directed];
    Fragmentation { fragments, origins, debris, reactions, report }.into()
}

#[test]
fn verdicts_come_back() -> Result<(), WireError> {
    let (solver, text) = ("brittle".to_owned(), "too thin".to_owned());
    let refused = Verdict::Refused { solver: solver.clone(), text: text.clone() };
    let failed = Verdict::Failed { solver, text };
    for verdict in [sample(), refused, failed] {
        assert_eq!(Verdict::decode(&verdict.encode()?)?, verdict);
    }
    Ok(())
}

fn fracture() -> Fragmentation {
    let Verdict::Solved(outcome) = sample() else { panic!("another verdict") };
    outcome.fracture().expect("a fracture")
}

#[test]
fn a_body_of_a_new_shape_comes_back() -> Result<(), WireError> {
    let deformation = Deformation {
        body: tetrahedron().into(),
        hulls: vec![vec![Vec3::x(); 4], vec![Vec3::y(); 5]],
        velocity: Vec3::x(),
        spin: Vec3::y(),
        work: 2.5,
        reactions: vec![0.5],
        report: Report::default().with("plastic_strain", "1", 0.1),
    };
    let verdict = |d: &Deformation| Verdict::Solved(SolveOutcome::Deformed(Box::new(d.clone())));
    let bytes = verdict(&deformation).encode()?;
    assert_eq!(Verdict::decode(&bytes)?, verdict(&deformation));
    let dear = Deformation { work: f64::NAN, ..deformation };
    assert!(matches!(verdict(&dear).encode(), Err(WireError::NotFinite { .. })));
    Ok(())
}

/// What caches hold that version 0.1 filled.
#[test]
fn verdicts_of_version_0_1_are_read() -> Result<(), WireError> {
    let mut now = fracture();
    let Verdict::Solved(_) = sample() else { panic!("another verdict") };
    let old = |now: &Fragmentation, solver: &str| {
        let report = OldReport {
            solver: solver.to_owned(),
            refusal: now.report.refusal.clone(),
            warnings: now.report.warnings.clone(),
            strength_ratio: 0.5,
            ..OldReport::default()
        };
        let counts = PartCounts { fragments: 3, hulls: 4, grains: 2 };
        let head = VerdictHeader::Old { counts, reactions: now.reactions.clone(), report };
        let bytes = encode_parts(now)?;
        let (_, _, slabs) = envelope::split(&bytes)?;
        envelope::seal(MessageKind::Verdict, &head, slabs)
    };
    let read = |bytes: Vec<u8>| match Verdict::decode(&bytes)? {
        Verdict::Solved(outcome) => Ok(outcome.fracture().expect("a fracture")),
        other => panic!("{other:?}"),
    };
    let marked = read(old(&now, "geometric")?)?;
    assert_eq!((&marked.fragments, &marked.debris), (&now.fragments, &now.debris));
    assert_eq!(marked.report.detail(STRENGTH_RATIO), Some(0.5));
    assert_eq!(marked.origins, now.origins);
    now.origins.clear();
    let drawn = read(old(&now, "geometric")?)?;
    assert_eq!(drawn.origins, [FragmentOrigin::Sampled; 3], "the geometric family sampled all");
    assert!(read(old(&now, "brittle")?)?.origins.is_empty(), "that is not known");
    now.origins = vec![FragmentOrigin::Sampled];
    assert!(encode_parts(&now).is_err(), "a mark for each or none");
    Ok(())
}

#[test]
fn long_words_are_cut_between_letters() -> Result<(), WireError> {
    let text = "ä".repeat(MAX_TEXT);
    let long = Verdict::Failed { solver: "x".into(), text };
    let Verdict::Failed { text, .. } = Verdict::decode(&long.encode()?)? else {
        panic!("another verdict");
    };
    assert_eq!(text, "ä".repeat(MAX_TEXT / 2));
    Ok(())
}

#[test]
fn counts_that_promise_too_much_allocate_nothing() -> Result<(), WireError> {
    let header = |fragments, grains| VerdictHeader::Parts {
        counts: PartCounts { fragments, hulls: 0, grains },
        reactions: Vec::new(),
        report: Report::default(),
    };
    let head = header(16_000, 0);
    let bytes = envelope::seal(MessageKind::Verdict, &head, &[1, 2, 3])?;
    assert!(matches!(Verdict::decode(&bytes), Err(WireError::Short { have: 3, .. })));
    for head in [header(u32::MAX, 0), header(0, u32::MAX)] {
        let bytes = envelope::seal(MessageKind::Verdict, &head, &[])?;
        assert!(matches!(Verdict::decode(&bytes), Err(WireError::Limit { .. })));
    }
    let bytes = envelope::seal(MessageKind::Verdict, &header(0, 2), &[0; 64])?;
    assert!(matches!(Verdict::decode(&bytes), Err(WireError::Short { have: 64, need: 128, .. })));
    Ok(())
}

/// A changed header is given a right checksum again, so that the damage gets past it.
fn damaged(good: &[u8], round: u64) -> Vec<u8> {
    let mut bad = good.to_vec();
    let draw = |k: u64, n: usize| (unit(round, k, 9) * n as f64) as usize;
    for change in 0..1 + draw(0, 4) as u64 {
        let at = draw(3 * change + 1, bad.len());
        bad[at] = match draw(3 * change + 2, 4) {
            0 => 0,
            1 => 0xff,
            2 => bad[at] ^ (1 << draw(3 * change + 3, 8)),
            _ => draw(3 * change + 3, 256) as u8,
        };
    }
    if draw(99, 5) == 0 {
        bad.truncate(draw(98, bad.len()));
    }
    if bad.len() > envelope::PREFIX && draw(97, 2) == 0 {
        bad[..12].copy_from_slice(&good[..12]);
        let length = u32::from_le_bytes([bad[12], bad[13], bad[14], bad[15]]) as usize;
        let end = bad.len().min(envelope::PREFIX + length);
        let sum = crc32c::crc32c(&bad[envelope::PREFIX..end]);
        bad[16..20].copy_from_slice(&sum.to_le_bytes());
    }
    bad
}

#[test]
fn damaged_bytes_never_panic_and_what_passes_is_sound() -> Result<(), WireError> {
    let (verdict, job) = (sample().encode()?, job().encode()?);
    let mut passed = 0;
    for round in 0..60_000 {
        if let Ok(Verdict::Solved(SolveOutcome::Broken(body))) =
            Verdict::decode(&damaged(&verdict, round))
        {
            passed += 1;
            for fragment in &body.fragments {
                let n = fragment.solid.mesh.vertices.len() as u32;
                assert!(fragment.solid.mesh.triangles.iter().flatten().all(|i| *i < n));
                assert!(fragment.velocity.iter().all(|x| x.is_finite()));
                assert_eq!(fragment.sheet.validate(), Ok(()));
            }
            assert!(body.debris.iter().all(|grain| grain.volume.is_finite()));
        }
        if let Ok(job) = FractureJob::decode(&damaged(&job, round)) {
            assert!(job.problem.law.density().is_finite());
        }
    }
    assert!(passed > 100, "only {passed} got past the checksum");
    Ok(())
}
