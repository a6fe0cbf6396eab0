//! Everything that crosses a process boundary: envelopes, messages of the pool, jobs, verdicts,
//! specimens and what came of them, and blobs in pieces.

use super::bytes::{INPUT, damaged};
use super::timed;
use cullet_geometry::{Sheet, Solid, TriMesh, Vec3, shapes};
use cullet_lab::specimen;
use cullet_model::strength::{Region, Stroke};
use cullet_model::{
    ArtDirection, BodyRegion, Fragment, FragmentOrigin, Fragmentation, Grain, Law, Report,
    SolveOutcome, Support,
};
use cullet_proto::chunks::{self, Assembly, CHUNK};
use cullet_proto::claim::{Claim, Reply};
use cullet_proto::envelope::PREFIX;
use cullet_proto::keys::{parse_live, parse_rpc};
use cullet_proto::outline::{Outline, Parted};
use cullet_proto::service::{self, BundleFile, BundleTable};
use cullet_proto::specimen::{Ending, Frame, Price, SpecimenJob, SpecimenOutcome, SpecimenResult};
use cullet_proto::{Epoch, FractureJob, JobId, SessionId, Verdict, WireError, WorkerId, pool};
use cullet_tests::root;
use serde::de::DeserializeOwned;
use std::panic::RefUnwindSafe;

fn cube() -> Solid {
    let mesh = shapes::cuboid(Vec3::repeat(0.1), shapes::Detail::default()).expect("a box");
    Solid::outer(mesh)
}

fn job() -> FractureJob {
    let (point, normal) = (Vec3::zeros(), Vec3::z());
    let support = Support { point, normal, radius: 0.02, mobility: 0.1 };
    let region = Region::Sphere { centre: Vec3::zeros(), radius: 1.0 };
    let mut job = FractureJob::smallest("brittle", 7);
    job.fallback = Some("geometric".into());
    job.problem.body = cube().into();
    job.problem.supports = vec![support];
    job.problem.spin = Vec3::z();
    let Law::Brittle { strength, .. } = &mut job.problem.law else { panic!("another law") };
    strength.strokes = vec![Stroke { region, factor: 0.5, edge: 0.0 }];
    job
}

/// A job whose mesh does not fit its outline.
fn parted() -> Parted {
    let detail = shapes::Detail { edge: Some(0.01), ..shapes::Detail::default() };
    let mesh = shapes::cuboid(Vec3::repeat(0.1), detail).expect("a box");
    let mut job = job();
    job.problem.body = Solid::outer(mesh).into();
    let parted = Parted::of(&job).expect("a job");
    assert_eq!(parted.parts.len(), 1);
    parted
}

fn verdict() -> Verdict {
    let mesh =
        TriMesh { vertices: vec![Vec3::zeros(), Vec3::x(), Vec3::y()], triangles: vec![[0, 1, 2]] };
    let sheet = Sheet { mesh, damage_time: vec![1e-5, 2e-5, 0.0], front_speed: vec![9.0; 3] };
    let fragment = Fragment {
        solid: cube(),
        hulls: vec![vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()]],
        velocity: Vec3::x(),
        spin: Vec3::y(),
        sheet,
    };
    let other = Fragment { hulls: Vec::new(), sheet: Sheet::default(), ..fragment.clone() };
    let grain = Grain { position: Vec3::x(), velocity: Vec3::y(), volume: 1e-9, size: 1e-3 };
    Fragmentation {
        fragments: vec![fragment, other],
        origins: vec![FragmentOrigin::Solved, FragmentOrigin::Directed],
        debris: vec![grain],
        reactions: vec![0.5],
        report: Report { warnings: vec!["a word".into()], ..Report::default() },
    }
    .into()
}

/// What a body must be once it is past the door.
fn is_sound(solid: &Solid) {
    let vertices = solid.mesh.vertices.len() as u32;
    assert!(solid.mesh.triangles.iter().flatten().all(|i| *i < vertices));
    assert!(solid.mesh.vertices.iter().flatten().all(|x| x.is_finite()));
    assert_eq!(solid.surface.len(), solid.mesh.triangles.len());
}

/// Damages messages, in every other case with the header's checksum made right again: the damage
/// gets past it.
fn hold(seeds: &[Vec<u8>], read: impl Fn(usize, &[u8]) + RefUnwindSafe) {
    for (which, seed) in seeds.iter().enumerate() {
        read(which, seed);
    }
    let check = bolero::check!().with_iterations(20_000).with_max_len(INPUT);
    check.for_each(|input: &[u8]| {
        let (which, mut bytes) = damaged(input, seeds);
        if input.len().is_multiple_of(2) && bytes.len() > PREFIX {
            bytes[..12].copy_from_slice(&seeds[which][..12]);
            let length = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]);
            let end = bytes.len().min(PREFIX.saturating_add(length as usize));
            let sum = chunks::sum(&bytes[PREFIX..end]);
            bytes[16..20].copy_from_slice(&sum.to_le_bytes());
        }
        timed("a message", || read(which, &bytes));
    });
}

fn in_words<T>(result: Result<T, WireError>) -> Option<T> {
    result.map_err(|error| assert!(!error.to_string().is_empty())).ok()
}

#[test]
fn jobs_and_verdicts() {
    let mut directed = job();
    let (pieces, guides) = (Some(12), vec![Vec3::zeros()]);
    let whole = vec![BodyRegion::Ball { centre: Vec3::zeros(), radius: 0.01 }];
    directed.direction = Some(ArtDirection { pieces, guides, whole });
    let seeds = [job().encode(), verdict().encode(), directed.encode()];
    let seeds = seeds.map(|sealed| sealed.expect("a message"));
    hold(&seeds, |which, bytes| {
        if which != 1 {
            let Some(job) = in_words(FractureJob::decode(bytes)) else { return };
            is_sound(job.problem.body.solid().expect("a solid"));
            assert!(job.problem.law.density().is_finite());
            assert!(job.id().is_ok(), "what was read can be written");
        } else if let Some(Verdict::Solved(SolveOutcome::Broken(body))) =
            in_words(Verdict::decode(bytes))
        {
            body.fragments.iter().for_each(|fragment| is_sound(&fragment.solid));
            let moves = body.fragments.iter().flat_map(|f| f.velocity.iter().chain(f.spin.iter()));
            assert!(moves.copied().all(f64::is_finite));
        }
    });
}

#[test]
fn outlines() {
    let parted = parted();
    let parts: Vec<&[u8]> = parted.parts.iter().map(|(_, part)| part.as_slice()).collect();
    hold(std::slice::from_ref(&parted.outline), |_, bytes| {
        let Some(outline) = in_words(Outline::open(bytes)) else { return };
        let total: u64 = outline.parts.iter().map(|part| part.length).sum();
        assert!(total <= chunks::MAX_BLOB, "what is to be fetched is bounded");
        // With its parts or with others: a job, something else, or nothing; never a panic.
        for parts in [&parts[..], &[], &[&[]]] {
            if let Some(job) = outline.whole(parts).filter(|job| JobId::of(job) == parted.id) {
                assert!(FractureJob::decode(&job).is_ok());
            }
        }
    });
}

#[test]
fn specimens_and_results() {
    let file = root().join("tests/specimens/d2-branching.toml");
    let specimen = specimen::load(&file, &[]).expect("a specimen");
    let specimen = specimen.job().expect("one of a body");
    let outcome = SpecimenOutcome {
        pieces: vec![0.5, 0.25],
        times: vec![0.0, 1.0],
        rows: vec![vec![1.0, 2.0], vec![3.0, 4.0]],
        frames: vec![Frame { time: 0.5, points: vec![[1.0, 2.0, 3.0, 4.0]; 3] }],
        ..SpecimenOutcome::ended(Ending::Refused("too thin".into()))
    };
    let result = SpecimenResult { outcome, price: Price::default() };
    let seeds = [specimen.encode().expect("a job"), result.encode().expect("a result")];
    hold(&seeds, |which, bytes| {
        if which == 0 {
            let Some(job) = in_words(SpecimenJob::decode(bytes)) else { return };
            is_sound(&Solid::outer(job.0.body.mesh.clone()));
            assert!(job.id().is_ok(), "what was read can be written");
        } else if let Some(result) = in_words(SpecimenResult::decode(bytes)) {
            let out = &result.outcome;
            assert!(out.rows.iter().all(|row| row.len() == out.times.len()));
        }
    });
}

/// Reads a message as every kind of question and answer there is.
fn read_all(bytes: &[u8]) {
    fn ask<T: DeserializeOwned>(bytes: &[u8]) {
        if let Err(refusal) = pool::read_ask::<T>(bytes) {
            assert!(!refusal.to_string().is_empty() && !pool::refuse(&refusal).is_empty());
        }
    }
    fn answer<T: DeserializeOwned>(bytes: &[u8]) {
        let _read = in_words(pool::read_answer::<T>(bytes).map(|_| ()));
    }
    ask::<pool::Hello>(bytes);
    ask::<pool::Poll>(bytes);
    ask::<pool::FetchBlob>(bytes);
    ask::<pool::Renew>(bytes);
    ask::<pool::Heed>(bytes);
    ask::<Claim>(bytes);
    ask::<pool::Chunk>(bytes);
    ask::<pool::Commit>(bytes);
    ask::<pool::Fail>(bytes);
    ask::<pool::Bye>(bytes);
    answer::<pool::PollAnswer>(bytes);
    answer::<pool::FetchAnswer>(bytes);
    answer::<pool::RenewAnswer>(bytes);
    answer::<pool::HeedAnswer>(bytes);
    answer::<Reply>(bytes);
    answer::<pool::ChunkAnswer>(bytes);
    answer::<pool::CommitAnswer>(bytes);
    answer::<pool::Acknowledged>(bytes);
    let _refusal = in_words(pool::read_refusal(bytes));
}

/// Reads a message as every kind of question of people and programs, and as a bundle's table.
fn read_json(bytes: &[u8]) {
    fn json<T: DeserializeOwned>(bytes: &[u8]) {
        let _read = in_words(service::open::<T>(bytes).map(|_| ()));
    }
    json::<service::Submit>(bytes);
    json::<service::BundlePiece>(bytes);
    json::<service::Which>(bytes);
    json::<service::Follow>(bytes);
    json::<service::FetchFile>(bytes);
    json::<service::Drain>(bytes);
    json::<service::RunUpdate>(bytes);
    json::<service::Runs>(bytes);
    json::<BundleTable>(bytes);
}

#[test]
fn questions_in_json() {
    let submit = service::Submit {
        ticket: "t".into(),
        overrides: vec!["world.seed=1".into()],
        digest: Some(service::hex_of(&[7; 32])),
        ..service::Submit::default()
    };
    let file = BundleFile { key: "scene/a.toml".into(), length: 5 };
    let (name, main) = ("a".into(), "scene/a.toml".into());
    let table = BundleTable { name, main, files: vec![file] };
    let follow = service::Follow { run: 7, from: 3, wait_ms: 100 };
    let samples: Vec<Vec<u8>> =
        [service::seal(&submit, b""), service::seal(&table, b"hello"), service::seal(&follow, b"")]
            .into_iter()
            .flatten()
            .collect();
    assert_eq!(samples.len(), 3);
    hold(&samples, |_, bytes| read_json(bytes));
}

#[test]
fn messages() {
    let (session, epoch, job) = (SessionId(1), Epoch(2), JobId([3; 32]));
    let poll = pool::Poll { session, seq: 5, slots: 1, threads: 2 };
    let commit =
        pool::Commit { session, job, epoch, digest: [9; 32], length: 77, next: Some(poll) };
    let trouble = pool::GiveBackReason::Crashed;
    let fail = pool::Fail { session, job, epoch, trouble, text: "it died".into() };
    let missing = pool::CommitAnswer::Missing(vec![1, 2, 3]);
    let refusal = pool::QuestionRefusal::TooLarge { bytes: 9, limit: 8 };
    let family = pool::Family { name: "brittle".into(), single: true, double: true };
    let hello = pool::Hello { session, families: Some(vec![family]), ..pool::Hello::default() };
    let grant =
        pool::Grant { job, run: 4, epoch, length: 77, lease_ms: 5, renew_ms: 6, hard_ms: 7 };
    let claim = Claim { life: session, host: "hub".into(), ..Claim::default() };
    let sealed = [
        pool::ask(&claim, &[]),
        pool::answer(&Reply { claim, stays: true }, &[]),
        pool::ask(&pool::Heed { session, job, epoch }, &[]),
        pool::ask(&hello, &[]),
        pool::answer(&pool::PollAnswer::Grant(grant), &[]),
        pool::ask(&poll, &[]),
        pool::ask(&commit, &[]),
        pool::ask(&fail, &[]),
        pool::answer(&missing, &[]),
        Ok(pool::refuse(&refusal)),
    ];
    let seeds = sealed.map(|bytes| bytes.expect("it fits"));
    hold(&seeds, |_, bytes| read_all(bytes));
}

/// Keys and names from the network: what is taken for one can be written as one.
#[test]
fn keys() {
    let coordinator = WorkerId::new("hub").expect("a name");
    let worker = WorkerId::new("w-1").expect("a name");
    let live = cullet_proto::keys::worker_live(&coordinator, &worker, SessionId(7));
    let verb = cullet_proto::keys::WorkerVerb::Poll;
    let rpc = cullet_proto::keys::worker_rpc(&coordinator, &worker, verb);
    let seeds = [live.into_bytes(), rpc.into_bytes(), b"w-1".to_vec()];
    bolero::check!().with_iterations(20_000).with_max_len(INPUT).for_each(|input: &[u8]| {
        let text = String::from_utf8_lossy(&damaged(input, &seeds).1).into_owned();
        if let Some((worker, _)) = parse_live(&text) {
            assert!(WorkerId::new(worker.as_str()).is_ok(), "{text}");
        }
        let _verb = parse_rpc(&text);
        if let Ok(name) = WorkerId::new(&text) {
            assert!(!name.as_str().contains(['*', '/', '$', '?', '#']), "{text}");
        }
    });
}

/// Pieces come damaged, twice, in any order, or not: the whole is the original or nothing, and
/// memory is taken for what has come.
#[test]
fn assembly() {
    let original: Vec<u8> = (0..2 * CHUNK + 5).map(|i| (i * 7 + i / 251) as u8).collect();
    bolero::check!().with_iterations(60).with_max_len(48).for_each(|input: &[u8]| {
        let mut blob = Assembly::new(original.len() as u64).expect("it fits");
        let mut most = 0;
        for piece in input.chunks_exact(3) {
            let index = u32::from(piece[0] % 5);
            let mut chunk = chunks::slice(&original, index).unwrap_or_default().to_vec();
            let sum = chunks::sum(&chunk);
            match piece[1] % 4 {
                0 if !chunk.is_empty() => {
                    let at = usize::from(piece[2]) * 4096 % chunk.len();
                    chunk[at] ^= 1;
                    assert!(blob.put(index, sum, &chunk).is_err(), "a damaged piece");
                }
                1 => {
                    chunk.push(0);
                    assert!(blob.put(index, sum, &chunk).is_err(), "a longer piece");
                }
                _ => {
                    let taken = blob.put(index, sum, &chunk).is_ok();
                    assert_eq!(taken, index < 3, "piece {index}");
                    most = most.max(if taken { (index as usize + 1) * CHUNK } else { 0 });
                }
            }
            assert!(blob.held() <= most);
        }
        assert_eq!(blob.whole().is_some(), blob.missing(9).is_empty());
        assert!(blob.whole().is_none_or(|whole| whole == original));
    });
    for length in [chunks::MAX_BLOB + 1, u64::MAX] {
        assert!(matches!(Assembly::new(length), Err(WireError::Limit { .. })));
    }
}
