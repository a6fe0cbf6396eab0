//! The recording held to its word on a run made by hand.

use super::synthetic::{self, BREAK, STEP, STEPS};
use super::*;
use cullet_geometry::math::scramble;
use cullet_geometry::{Sheet, Vec3};
use std::collections::BTreeMap;
use std::path::Path;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn recorded(dir: &Path) -> Finished {
    synthetic::run(&dir.join("run.mcap"), &synthetic::meta()).expect("records")
}

#[test]
fn the_summary_says_what_happened() {
    let dir = folder();
    let Finished { path, summary } = recorded(dir.path());
    assert_eq!(path, dir.path().join("run.mcap"));
    assert!(!dir.path().join("run.mcap.partial").exists());
    assert_eq!((summary.scene.as_str(), summary.seed), ("split", 7));
    assert_eq!((summary.steps, summary.sim_seconds), (STEPS, STEPS as f64 * STEP));
    assert_eq!((summary.bodies_initial, summary.bodies_final), (2, 3));
    assert_eq!((summary.fractures, summary.fragments), (1, 2));
    let jobs = Jobs { opened: 1, settled: 1, ..Default::default() };
    assert_eq!(summary.jobs, jobs);
    assert_eq!(summary.solvers, BTreeMap::from([("geometric".to_owned(), 1)]));
    assert_eq!(summary.ledger.fracture_energy, 3.2);
    assert_eq!(summary.open_fragments, 0);
    assert_eq!((summary.grains, summary.grain_mass), (2, 0.03));
    assert!((summary.smallest_volume_ratio - 0.5).abs() < 1e-12);
    assert_eq!(summary.digest.len(), 64);
}

#[test]
fn inspect_reads_the_same_summary_from_the_messages_alone() {
    let dir = folder();
    let finished = recorded(dir.path());
    let read = inspect(&finished.path).expect("reads");
    assert!(read.complete);
    assert_eq!(read.summary, finished.summary);
    assert_eq!(read.summary.to_json(), finished.summary.to_json());
    let back: Summary = serde_json::from_str(&read.summary.to_json()).expect("is JSON");
    assert_eq!(back, read.summary);
    assert_eq!(read.events.len(), 6);
    assert!(read.events[0].contains("slab hits cube"), "{}", read.events[0]);
    let opened = "opened for cube, asks geometric: generation 2 is beyond 1";
    assert!(read.events[1].ends_with(opened), "{}", read.events[1]);
    assert!(
        read.events[3].contains("cube breaks into 2 and 2 grains of 3.000e-2 kg"),
        "{}",
        read.events[3]
    );
}

#[test]
fn equal_runs_give_equal_bytes_and_wall_time_never_reaches_the_digest() {
    let (a, b, c) = (folder(), folder(), folder());
    let read = |f: &Finished| std::fs::read(&f.path).expect("reads");
    let (first, second) = (recorded(a.path()), recorded(b.path()));
    assert_eq!(read(&first), read(&second));
    let mut timed = synthetic::meta();
    timed.deterministic = false;
    let third = synthetic::run(&c.path().join("run.mcap"), &timed).expect("records");
    assert_ne!(read(&first), read(&third));
    assert_eq!(first.summary.digest, third.summary.digest);
    assert_eq!(third.summary.jobs.resent, 1);
    assert!(third.summary.wall_seconds > 0.0);
    assert_eq!(inspect(&third.path).expect("reads").summary, third.summary);
}

#[test]
fn grains_are_told_while_they_fly_and_never_lost() {
    let dir = folder();
    let recording = Recording::open(&recorded(dir.path()).path).expect("reads");
    let births: Vec<_> = recording.debris.iter().filter(|d| !d.masses.is_empty()).collect();
    assert_eq!(births.len(), 1);
    assert_eq!((births[0].step, births[0].ids.as_slice()), (BREAK, &[0, 1][..]));
    assert_eq!((births[0].parents.as_slice(), births[0].sizes[0]), (&[1, 1][..], 0.02));
    let last = recording.debris.last().expect("grains");
    let rested = BREAK + (0.3 / STEP) as u64 + 1;
    assert_eq!(last.step, rested, "the row in which they came to rest is the last");
    assert_eq!(recording.debris.len() as u64, rested - BREAK + 1, "a row a step");
    assert!(last.positions[2].abs() < 0.011 && last.velocities.iter().all(|v| *v == 0.0));
}

#[test]
fn cracks_that_end_inside_are_told_with_their_body_and_drawn_as_lines() {
    let dir = folder();
    let recording = Recording::open(&recorded(dir.path()).path).expect("reads");
    let [cracks] = &recording.cracks[..] else { panic!("{}", recording.cracks.len()) };
    assert_eq!((cracks.body, cracks.step), (2, BREAK));
    let half = synthetic::half();
    assert_eq!(Sheet::try_from(cracks), Ok(synthetic::fin(half)));
    // Only the edge at the top is seen.
    let traces = super::traces(&synthetic::block(half, 1.0).mesh, &synthetic::fin(half));
    let [trace] = &traces[..] else { panic!("{traces:?}") };
    assert_eq!(trace.normal, Vec3::z());
    assert!(trace.ends.iter().all(|p| p.z == half.z));
    let mut recorder =
        synthetic::begin(&dir.path().join("b.mcap"), &synthetic::meta()).expect("begins");
    let nobody = recorder.cracks((1, 0.1), 9, &synthetic::block(half, 1.0), &synthetic::fin(half));
    assert!(matches!(nobody, Err(RecordError::UnknownBody { body: 9, .. })));
}

#[test]
fn the_digest_sees_one_bit_of_one_pose() {
    let digest = |nudge: f64| {
        let dir = folder();
        let path = dir.path().join("run.mcap");
        let mut recorder = synthetic::begin(&path, &synthetic::meta()).expect("begins");
        let row = PoseRow {
            id: 1,
            pose: cullet_geometry::Pose::translation(0.0, 0.0, 1.0 + nudge),
            velocity: cullet_geometry::Vec3::zeros(),
            spin: cullet_geometry::Vec3::zeros(),
        };
        recorder.poses(1, STEP, &[row]).expect("records");
        recorder.finish(1, STEP).expect("finishes").summary.digest
    };
    assert_eq!(digest(0.0), digest(0.0));
    assert_ne!(digest(0.0), digest(f64::EPSILON));
}

#[test]
fn the_pose_track_is_lossless_and_holds_only_what_changed() {
    let dir = folder();
    let recording = Recording::open(&recorded(dir.path()).path).expect("opens");
    let slab_rows = recording.poses.iter().filter(|p| p.ids.contains(&0)).count();
    assert_eq!(slab_rows, 1, "the slab never moves");
    let falling = recording.poses.iter().find(|p| p.step == 10).expect("step 10 is there");
    let time = 10.0 * STEP;
    let height = 0.9 - 0.5 * 9.81 * time * time;
    assert_eq!(falling.positions[2].to_bits(), height.to_bits());
    assert_eq!(falling.velocities[2].to_bits(), (-9.81 * time).to_bits());
}

#[test]
fn attachments_and_metadata_let_the_run_be_done_again() {
    let dir = folder();
    let recording = Recording::open(&recorded(dir.path()).path).expect("opens");
    assert_eq!(recording.attachments["scene.toml"], synthetic::meta().scene_text.as_bytes());
    assert_eq!(recording.attachments["note.txt"], b"by hand");
    let layout: serde_json::Value =
        serde_json::from_slice(&recording.attachments["layout.json"]).expect("is JSON");
    let shown = &layout["configById"]["3D!scene"]["topics"]["/scene/cube"]["visible"];
    assert_eq!(shown, &serde_json::Value::Bool(true));
    let axes = &layout["configById"]["3D!scene"]["transforms"]["frame:upright"]["visible"];
    assert_eq!(axes, false);
    assert_eq!(layout["configById"]["Plot!counts"]["lichtblickPanelTitle"], "Pieces");
    let camera = &layout["configById"]["3D!scene"]["cameraState"];
    assert!((camera["targetOffset"][2].as_f64().expect("a number") - 0.9).abs() < 1e-9);
    // The cube's corners are 0.1·√3 from its middle, and the box around that ball √3 further.
    assert!((camera["distance"].as_f64().expect("a number") - 4.0 * 0.3).abs() < 1e-9);
    assert_eq!(recording.meta["seed"], "7");
}

/// The messages of a topic: log time \[s\] and payload.
fn messages(path: &Path, topic: &str) -> Vec<(f64, Vec<u8>)> {
    let bytes = std::fs::read(path).expect("reads");
    let all = mcap::MessageStream::new(&bytes).expect("opens").map(|m| m.expect("is whole"));
    let of_topic = all.filter(|m| m.channel.topic == topic);
    of_topic.map(|m| (m.log_time as f64 * 1e-9, m.data.into_owned())).collect()
}

#[test]
fn every_drawing_is_the_whole_state_and_none_comes_too_often() {
    use foxglove::Decode as _;
    let dir = folder();
    let path = recorded(dir.path()).path;
    let drawn = messages(&path, "/scene/cube");
    let at_break = BREAK as f64 * STEP;
    for pair in drawn.windows(2) {
        let gap = pair[1].0 - pair[0].0;
        let forced = (pair[1].0 - at_break).abs() < 1e-9 || (pair[1].0 - 1.0).abs() < 1e-9;
        assert!(forced || gap > 1.0 / 15.0 - 1e-6, "{gap}");
    }
    for (time, payload) in &drawn {
        let update = foxglove::messages::SceneUpdate::decode(&payload[..]).expect("decodes");
        assert_eq!(update.deletions.len(), 1);
        let parts = update.entities.iter().map(|e| e.triangles.len()).sum::<usize>();
        // A whole cube; then two halves, each with a crack face of its own colour.
        assert_eq!(parts, if *time < at_break - 1e-9 { 1 } else { 4 }, "at {time}");
    }
    assert_eq!(messages(&path, "/scene/slab").len(), 1, "it never moves");
    assert!(drawn.iter().any(|(t, _)| (t - at_break).abs() < 1e-9), "the break is drawn at once");
}

#[test]
fn without_drawings_the_rest_of_the_recording_is_the_same() {
    let (with, without) = (folder(), folder());
    let drawn = recorded(with.path());
    let meta = RunMeta { drawings: false, ..synthetic::meta() };
    let bare = synthetic::run(&without.path().join("run.mcap"), &meta).expect("records");
    assert_eq!(bare.summary, drawn.summary);
    assert_eq!(inspect(&bare.path).expect("reads").summary, drawn.summary);
    for object in ["/scene/cube", "/scene/slab"] {
        assert!(messages(&bare.path, object).is_empty(), "{object}");
        assert!(!messages(&drawn.path, object).is_empty(), "{object}");
    }
    for topic in ["/fragments", "/tf", "/log", STATS, GEOMETRY, BODY, BODIES, DEBRIS, EVENTS] {
        assert_eq!(messages(&bare.path, topic), messages(&drawn.path, topic), "{topic}");
    }
    // A viewer shows the centres in their place.
    let layout = &Recording::open(&bare.path).expect("opens").attachments["layout.json"];
    let layout: serde_json::Value = serde_json::from_slice(layout).expect("is JSON");
    let topics = &layout["configById"]["3D!scene"]["topics"];
    assert_eq!(*topics, serde_json::json!({ "/fragments": { "visible": true } }));
}

#[test]
fn drawings_keep_to_their_budget_and_the_track_stays_whole() {
    let dir = folder();
    let path = dir.path().join("run.mcap");
    let meta = RunMeta { duration: 1.0, ..synthetic::meta() };
    let mut recorder = synthetic::begin(&path, &meta).expect("begins");
    // 250 objects of 3,700 triangles each, all moving: 15 drawings a second would be 360 MB.
    let solid = super::display::tests::ring(43);
    let geometry = recorder.geometry(&solid).expect("records").to_vec();
    let ids: Vec<u64> = (100..350).collect();
    for &id in &ids {
        let body = cullet_proto::recording::Body {
            id,
            name: format!("ring{id}"),
            object: format!("ring{id}"),
            geometry: geometry.clone(),
            ..Default::default()
        };
        recorder.body(&body).expect("records");
    }
    let row = |id: u64, step: u64| PoseRow {
        id,
        pose: cullet_geometry::Pose::translation(id as f64, 0.0, 0.01 * step as f64),
        velocity: cullet_geometry::Vec3::zeros(),
        spin: cullet_geometry::Vec3::zeros(),
    };
    for step in 0..30 {
        let mut rows = vec![row(0, 0), row(1, 0)];
        rows.extend(ids.iter().map(|&id| row(id, step)));
        recorder.poses(step, step as f64 / 30.0, &rows).expect("records");
    }
    recorder.finish(30, 1.0).expect("finishes");
    let bytes = std::fs::read(&path).expect("reads");
    let (mut drawn, mut rows) = (0, 0);
    for message in mcap::MessageStream::new(&bytes).expect("opens") {
        let message = message.expect("is whole");
        drawn += if message.channel.topic.starts_with("/scene/") { message.data.len() } else { 0 };
        rows += u32::from(message.channel.topic == BODIES);
    }
    // The budget, and the last drawing of each object, which is always made.
    let forced = 250 * messages(&path, "/scene/ring100")[0].1.len();
    assert!(drawn < 205_000_000 + forced, "{drawn} with {forced} forced");
    assert_eq!(rows, 30);
    assert!(!messages(&path, "/scene/ring349").is_empty());
}

/// Number of pose messages that lie in whole chunks of the first `cut` bytes.
fn saved(bytes: &[u8], cut: usize, dir: &Path) -> Option<Recording> {
    let path = dir.join("cut.mcap.partial");
    std::fs::write(&path, &bytes[..cut]).expect("writes");
    Recording::open(&path).ok()
}

#[test]
fn a_file_cut_anywhere_reads_up_to_its_last_whole_chunk() {
    let dir = folder();
    let bytes = std::fs::read(recorded(dir.path()).path).expect("reads");
    let whole = saved(&bytes, bytes.len(), dir.path()).expect("opens");
    let summary = mcap::Summary::read(&bytes).expect("has a summary").expect("is indexed");
    let ends: Vec<u64> =
        summary.chunk_indexes.iter().map(|c| c.chunk_start_offset + c.chunk_length).collect();
    assert!(ends.len() >= 3, "several chunks: {}", ends.len());
    let mut last = 0;
    for cut in (0..bytes.len()).step_by(97) {
        let Some(read) = saved(&bytes, cut, dir.path()) else {
            assert!(cut < 8, "cut at {cut} must read");
            continue;
        };
        let chunks = ends.iter().filter(|&&end| end <= cut as u64).count();
        let messages = read.poses.len();
        assert!(messages >= last, "cut at {cut}");
        last = messages;
        if chunks == 0 {
            assert_eq!(messages, 0);
        }
        if chunks == ends.len() {
            assert_eq!(messages, whole.poses.len(), "cut at {cut}");
        }
        assert_eq!(read.poses[..], whole.poses[..messages], "cut at {cut}");
        assert!(!read.complete, "cut at {cut}");
    }
}

#[test]
fn a_recovered_file_is_whole_for_any_reader() {
    let dir = folder();
    let bytes = std::fs::read(recorded(dir.path()).path).expect("reads");
    let cut = dir.path().join("cut.mcap.partial");
    let out = dir.path().join("out.mcap");
    for share in [0.3, 0.5, 0.7, 0.9, 1.0] {
        let end = (bytes.len() as f64 * share) as usize;
        std::fs::write(&cut, &bytes[..end]).expect("writes");
        let report = recover(&cut, &out).expect("recovers");
        let copy = std::fs::read(&out).expect("reads");
        let indexed = mcap::Summary::read(&copy).expect("ends well").expect("is indexed");
        let stats = indexed.stats.expect("has statistics");
        assert_eq!(stats.message_count, report.messages);
        let streamed = mcap::MessageStream::new(&copy).expect("opens");
        let whole = streamed.filter(Result::is_ok).count() as u64;
        assert_eq!(whole, report.messages);
        assert_eq!(report.complete, share >= 1.0);
        let (a, b) = (inspect(&cut).expect("reads"), inspect(&out).expect("reads"));
        assert_eq!(a.summary, b.summary);
        assert_eq!(
            Recording::open(&out).expect("opens").attachments.len() as u64,
            report.attachments
        );
    }
}

#[test]
fn a_chunk_with_one_wrong_bit_is_left_out_and_the_others_are_kept() {
    let dir = folder();
    let bytes = std::fs::read(recorded(dir.path()).path).expect("reads");
    let index = mcap::Summary::read(&bytes).expect("reads").expect("is indexed").chunk_indexes;
    let chunk = &index[1];
    let start = chunk.compressed_data_offset().expect("has data") as usize;
    let (damaged, out) = (dir.path().join("damaged.mcap"), dir.path().join("out.mcap"));
    for at in (start..start + chunk.compressed_size as usize).step_by(53) {
        let mut copy = bytes.clone();
        copy[at] ^= 4;
        std::fs::write(&damaged, &copy).expect("writes");
        let report = recover(&damaged, &out).expect("recovers");
        assert_eq!((report.damaged, report.chunks), (1, index.len() as u64 - 1), "bit at {at}");
        assert!(!Recording::open(&damaged).expect("opens").complete, "bit at {at}");
    }
}

#[test]
fn a_recording_all_of_which_is_damaged_is_refused_and_leaves_no_file() {
    let dir = folder();
    let mut bytes = std::fs::read(recorded(dir.path()).path).expect("reads");
    let summary = mcap::Summary::read(&bytes).expect("reads").expect("is indexed");
    let data =
        |chunk: &mcap::records::ChunkIndex| chunk.compressed_data_offset().expect("has data");
    let chunks = summary.chunk_indexes.iter().map(|chunk| data(chunk) + chunk.compressed_size / 2);
    let attachments = summary.attachment_indexes.iter().map(|one| one.offset + one.length / 2);
    let all: Vec<u64> = chunks.chain(attachments).collect();
    let damaged = all.len() as u64;
    all.into_iter().for_each(|at| bytes[at as usize] ^= 4);
    let (from, out) = (dir.path().join("damaged.mcap"), dir.path().join("out.mcap"));
    std::fs::write(&from, &bytes).expect("writes");
    let said = recover(&from, &out).expect_err("refused");
    assert!(matches!(said, RecordError::Lost { damaged: told, .. } if told == damaged), "{said}");
    let left = std::fs::read_dir(dir.path()).expect("a folder").flatten();
    let made = left.filter(|file| file.file_name().to_string_lossy().starts_with("out"));
    assert_eq!(made.count(), 0);
}

#[test]
fn a_run_that_is_dropped_leaves_no_final_name_and_what_it_flushed() {
    let dir = folder();
    let path = dir.path().join("run.mcap");
    let mut recorder = synthetic::begin(&path, &synthetic::meta()).expect("begins");
    for step in 0..BREAK + 10 {
        synthetic::step(&mut recorder, step).expect("steps");
    }
    // As a kill would: the file as it lies on the disk, with the last chunk open.
    let on_disk = std::fs::read(dir.path().join("run.mcap.partial")).expect("is there");
    std::mem::forget(recorder);
    assert!(!path.exists());
    let killed = dir.path().join("killed.mcap");
    std::fs::write(&killed, on_disk).expect("writes");
    let read = inspect(&killed).expect("reads");
    assert!(!read.complete);
    assert_eq!((read.summary.fractures, read.summary.fragments), (1, 2));
    let lagging = inspect(&path).expect("finds the partial file by the final name");
    assert_eq!(lagging.summary.fractures, 1);
}

#[test]
fn early_and_unknown_bodies_are_refused() {
    let dir = folder();
    let mut recorder =
        synthetic::begin(&dir.path().join("run.mcap"), &synthetic::meta()).expect("begins");
    let stray =
        cullet_proto::recording::Body { id: 9, geometry: vec![1; 32], ..Default::default() };
    assert!(matches!(recorder.body(&stray), Err(RecordError::UnknownGeometry { body: 9 })));
    let row = PoseRow {
        id: 9,
        pose: cullet_geometry::Pose::identity(),
        velocity: cullet_geometry::Vec3::zeros(),
        spin: cullet_geometry::Vec3::zeros(),
    };
    let refused = recorder.poses(0, 0.0, &[row]);
    assert!(matches!(refused, Err(RecordError::UnknownBody { body: 9, .. })));
    let refused = recorder.poses(0, f64::NAN, &[]);
    assert!(matches!(refused, Err(RecordError::NotFinite { .. })));
}

#[test]
fn files_that_are_no_recording_are_refused_by_name() {
    let dir = folder();
    let path = dir.path().join("text.mcap");
    std::fs::write(&path, "not at all").expect("writes");
    assert!(matches!(inspect(&path), Err(RecordError::NotMcap { .. })));
    assert!(recover(&path, &dir.path().join("out.mcap")).is_err());
    assert!(!dir.path().join("out.mcap").exists());
    assert!(!dir.path().join("out.mcap.recovering").exists());
    let missing = inspect(&dir.path().join("missing.mcap"));
    assert!(matches!(missing, Err(RecordError::Io { .. })));
}

#[test]
fn an_open_fragment_is_counted_by_both() {
    let dir = folder();
    let path = dir.path().join("run.mcap");
    let mut recorder = synthetic::begin(&path, &synthetic::meta()).expect("begins");
    let mut solid = synthetic::block(cullet_geometry::Vec3::repeat(0.1), 1.0);
    solid.mesh.triangles.pop();
    solid.surface.pop();
    let geometry = recorder.geometry(&solid).expect("records").to_vec();
    let body = cullet_proto::recording::Body {
        id: 5,
        object: "cube".to_owned(),
        parent: Some(1),
        geometry,
        volume: 0.004,
        ..Default::default()
    };
    recorder.body(&body).expect("records");
    let finished = recorder.finish(0, 0.0).expect("finishes");
    assert_eq!(finished.summary.open_fragments, 1);
    assert_eq!(inspect(&finished.path).expect("reads").summary.open_fragments, 1);
}

/// One byte changed in each of 200 copies, half of which are cut off somewhere too.
#[test]
fn damage_never_panics() {
    let (dir, damaged) = (folder(), folder());
    let sound = std::fs::read(recorded(dir.path()).path).expect("reads");
    let (path, out) = (damaged.path().join("damaged.mcap"), damaged.path().join("out.mcap"));
    let again = damaged.path().join("again.mcap");
    let mut dice = 0;
    let mut below = |end: usize| {
        dice = scramble(dice + 1);
        (dice >> 8) as usize % end
    };
    for _ in 0..200 {
        let mut bytes = sound.clone();
        bytes[below(sound.len())] = below(256) as u8;
        if below(2) == 0 {
            bytes.truncate(below(sound.len()));
        }
        std::fs::write(&path, &bytes).expect("writes");
        if let Ok(report) = recover(&path, &out) {
            let copy = std::fs::read(&out).expect("reads");
            let read = mcap::Summary::read(&copy).expect("ends well").expect("is indexed");
            assert_eq!(read.stats.expect("has statistics").message_count, report.messages);
            // Of one that is cut off at its very beginning there is nothing to recover again.
            if report.messages > 0 {
                let again = recover(&out, &again).expect("what was saved is whole");
                assert_eq!((again.damaged, again.messages), (0, report.messages));
                assert_eq!(again.complete, report.holes.is_empty(), "{again}");
            }
        }
        // A damaged message in a chunk without a check sum may be refused; it must not panic.
        let _outcome = inspect(&path).is_ok();
        std::fs::remove_file(&out).ok();
    }
}
