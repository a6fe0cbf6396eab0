use super::{Store, put};
use crate::ServiceError;
use cullet_geometry::Vec3;
use cullet_model::{Fragmentation, Grain};
use cullet_proto::ids::digest;
use cullet_proto::service::hex_of;
use cullet_proto::{JobId, Verdict};
use std::path::{Path, PathBuf};

#[test]
fn a_folder_of_others_is_refused_and_left_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    put(&folder.path().join("thesis.tex"), b"x").expect("a file");
    let said = Store::open(Some(folder.path())).expect_err("it is somebody else's");
    assert!(said.to_string().contains("thesis.tex"), "{said}");
    let newer = tempfile::tempdir().expect("a folder");
    put(&newer.path().join(super::MARK), b"cullet state 9\n").expect("a file");
    let said = Store::open(Some(newer.path())).expect_err("it is newer");
    assert!(said.to_string().contains("cullet state 9"), "{said}");
}

#[test]
fn one_coordinator_at_a_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let first = Store::open(Some(folder.path())).expect("it opens");
    let said = Store::open(Some(folder.path())).expect_err("it is taken");
    assert!(matches!(said, ServiceError::Taken { .. }), "{said}");
    drop(first);
    assert!(Store::open(Some(folder.path())).is_ok());
}

#[test]
fn a_damaged_verdict_is_no_verdict() {
    let store = Store::open(None).expect("a folder of its own");
    let (kept, job) = (store.kept(1), JobId([7; 32]));
    assert_eq!(kept.get(job), None);
    let verdict = Verdict::Refused { solver: "brittle".into(), text: "thin".into() };
    kept.put(job, &verdict).expect("it is kept");
    assert_eq!(kept.get(job), Some(verdict));
    let path = store.run(1).join("kept").join(job.to_string());
    // One of numbers alone, in which a bit that turns makes another verdict as sound as it.
    let grain = |k: i32| Grain {
        position: Vec3::repeat(f64::from(k)),
        velocity: Vec3::zeros(),
        volume: 1.0,
        size: 0.5,
    };
    let debris = (0..20).map(grain).collect();
    let broken = Verdict::from(Fragmentation { debris, ..Fragmentation::default() });
    kept.put(job, &broken).expect("it is kept");
    let sound = std::fs::read(&path).expect("it is there");
    let mut passed = 0;
    for at in (0..sound.len()).step_by(7) {
        let mut bytes = sound.clone();
        bytes[at] ^= 1;
        passed += usize::from(bytes.get(32..).is_some_and(|b| Verdict::decode(b).is_ok()));
        std::fs::write(&path, bytes).expect("it is damaged");
        assert_eq!(kept.get(job), None, "byte {at}");
    }
    assert!(passed > 50, "only {passed} of them decode: the digest is not what is tested");
    kept.put(job, &broken).expect("it is kept again");
    assert_eq!(kept.get(job), Some(broken));
}

/// What is in a folder, and in those in it.
fn files(folder: &Path) -> Vec<PathBuf> {
    let all = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let all = all.map(|file| file.path());
    all.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

#[test]
fn a_bundle_in_which_a_bit_turned_is_named_and_not_used() {
    let store = Store::open(None).expect("a folder of its own");
    let bytes = b"duration = 0.2 and a mesh";
    store.keep_bundle(7, bytes).expect("it is kept");
    let told = hex_of(&digest(bytes));
    assert_eq!(store.bundle(7, &told).expect("it is sound"), bytes);
    let path = store.run(7).join("bundle");
    for at in 0..8 * bytes.len() {
        let mut bad = bytes.to_vec();
        bad[at / 8] ^= 1 << (at % 8);
        std::fs::write(&path, &bad).expect("it is damaged");
        let said = store.bundle(7, &told).expect_err("a bit turned");
        assert!(matches!(said, ServiceError::Damaged { .. }), "bit {at}: {said}");
        assert!(said.to_string().contains("runs/7/bundle is damaged"), "{said}");
        assert_eq!(std::fs::read(&path).expect("it stays"), bad);
        // One that was handed in before there were digests is read as it is.
        assert_eq!(store.bundle(7, "").expect("nobody knows"), bad);
    }
}

#[test]
fn a_number_in_which_a_bit_turned_is_named_and_not_used() {
    let folder = tempfile::tempdir().expect("a folder");
    let store = Store::open(Some(folder.path())).expect("it opens");
    store.give(41).expect("it is noted");
    assert_eq!(store.given(7).expect("it is sound"), 41);
    for name in ["numbers", "incarnation"] {
        let path = folder.path().join(name);
        let sound = std::fs::read(&path).expect("a file");
        for at in 0..8 * sound.len() {
            let mut bad = sound.clone();
            bad[at / 8] ^= 1 << (at % 8);
            std::fs::write(&path, &bad).expect("it is damaged");
            let said = match name {
                "numbers" => store.given(7).map(drop),
                _ => store.next_life().map(drop),
            };
            let said = said.expect_err("a bit turned").to_string();
            assert!(said.contains(&format!("{name} is damaged")), "bit {at}: {said}");
            assert_eq!(std::fs::read(&path).expect("it stays"), bad);
        }
        std::fs::write(&path, &sound).expect("it is sound");
    }
}

/// The first of all files is the mark; who was killed as it was written can begin again.
#[test]
fn a_folder_whose_mark_was_cut_short_is_taken() {
    let folder = tempfile::tempdir().expect("a folder");
    put(&folder.path().join(".cullet-x1"), b"half").expect("a file");
    drop(Store::open(Some(folder.path())).expect("it opens"));
    let other = tempfile::tempdir().expect("a folder");
    put(&other.path().join("notes"), b"somebody's").expect("a file");
    assert!(matches!(Store::open(Some(other.path())), Err(ServiceError::Foreign { .. })));
}

#[test]
fn what_nobody_knows_of_is_set_aside_and_nothing_is_deleted() {
    let folder = tempfile::tempdir().expect("a folder");
    let store = Store::open(Some(folder.path())).expect("it opens");
    for (run, text) in [(1, "known"), (2, "lost"), (3, "never accepted")] {
        store.keep_bundle(run, text.as_bytes()).expect("a bundle");
    }
    put(&folder.path().join(".cullet-x1"), b"half").expect("a file");
    put(&store.run(1).join(".cullet-x2"), b"half of another").expect("a file");
    put(&folder.path().join("runs/notes"), b"somebody's").expect("a file");
    let text = |path: &PathBuf| std::fs::read_to_string(path).expect("a text");
    let before = files(folder.path()).iter().map(text).collect::<std::collections::BTreeSet<_>>();
    store.sweep(&|run| run == 1);
    let after = files(folder.path()).iter().map(text).collect();
    assert_eq!(before, after, "something is deleted");
    let mut left: Vec<_> = files(&folder.path().join("runs"));
    left.sort();
    let known = ["runs/1/bundle", "runs/notes"].map(|name| folder.path().join(name));
    assert_eq!(left, known);
    let aside = files(&folder.path().join("set-aside"));
    assert_eq!(aside.len(), 4, "{aside:?}");
    // Again, and another of the same name.
    store.keep_bundle(3, b"again").expect("a bundle");
    store.sweep(&|run| run == 1);
    assert_eq!(files(&folder.path().join("set-aside")).len(), 5);
}

#[test]
fn a_folder_of_the_first_generation_is_read_and_becomes_one_of_the_second() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [(super::MARK, super::OLD_TITLE), ("incarnation", "7\n")] {
        put(&folder.path().join(name), text.as_bytes()).expect("a file");
    }
    put(&folder.path().join("numbers"), b"12\n").expect("a file");
    let store = Store::open(Some(folder.path())).expect("it opens");
    assert_eq!((store.incarnation, store.given(3).expect("a number")), (Some(8), 12));
    let mark = std::fs::read_to_string(folder.path().join(super::MARK)).expect("a mark");
    assert_eq!(mark, super::TITLE);
}

#[cfg(unix)]
#[test]
fn a_state_folder_is_its_owners_alone_and_one_that_was_not_becomes_so() {
    use std::os::unix::fs::PermissionsExt;
    let mode = |path: &Path| std::fs::metadata(path).expect("it").permissions().mode() & 0o777;
    let place = tempfile::tempdir().expect("a folder");
    let folder = place.path().join("above/state");
    let store = Store::open(Some(&folder)).expect("it opens");
    store.keep_bundle(1, b"x").expect("a bundle");
    let verdict = Verdict::Refused { solver: "brittle".into(), text: "thin".into() };
    store.kept(1).put(JobId([7; 32]), &verdict).expect("it is kept");
    store.give(1).expect("it is noted");
    let all = files(&folder);
    assert!(all.len() >= 6, "{all:?}");
    for file in &all {
        assert_eq!(mode(file), 0o600, "{}", file.display());
    }
    assert_eq!([mode(&folder), mode(&store.run(1))], [0o700; 2]);
    drop(store);
    for (before, after) in [(0o755, 0o750), (0o707, 0o700), (0o750, 0o750)] {
        std::fs::set_permissions(&folder, PermissionsExt::from_mode(before)).expect("rights");
        Store::open(Some(&folder)).expect("it opens");
        assert_eq!(mode(&folder), after);
    }
}
