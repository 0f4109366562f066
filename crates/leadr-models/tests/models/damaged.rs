//! Tests of models with altered bytes and JSON. The models are accepted or refused with bounded memory and time, and without
//! crashes.

use std::time::Duration;

use leadr_models::Model;
use serde_json::{Value, json};

use crate::build::{decode, decode_strictly, everything, glb};
use crate::samples::models_under;
use leadr_testing::memory::{alone, measured};
use leadr_testing::shared::shared_data;

/// The memory limit for any altered file: the free amounts of unpacked data and of decoded images, and transient copies.
const MEMORY_LIMIT: usize = 400 << 20;
const TIME_LIMIT: Duration = Duration::from_secs(10);

/// A deterministic generator of pseudo-random numbers.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }
}

struct Outcome {
    memory_limit: usize,
    accepted: usize,
    refused: usize,
    peak: usize,
    slowest: Duration,
}

impl Outcome {
    fn within(memory_limit: usize) -> Self {
        Self { memory_limit, accepted: 0, refused: 0, peak: 0, slowest: Duration::ZERO }
    }

    fn run(&mut self, what: &dyn Fn() -> String, bytes: &[u8]) {
        let (result, peak, time) = measured(|| decode(bytes).map(|model| use_it(&model)));
        assert!(peak < self.memory_limit, "{}: {peak} bytes", what());
        assert!(time < TIME_LIMIT, "{}: {time:?}", what());
        self.peak = self.peak.max(peak);
        self.slowest = self.slowest.max(time);
        match result {
            Ok(()) => self.accepted += 1,
            Err(fault) => {
                let message = fault.to_string();
                assert!(!message.contains('\n') && message.len() < 700, "{}: {message}", what());
                self.refused += 1;
            }
        }
    }

    fn print(&self, what: &str) {
        let Self { accepted, refused, peak, slowest, .. } = self;
        println!("{what}: {accepted} accepted, {refused} refused, peak {peak} bytes, slowest {slowest:?}");
    }
}

/// Poses an accepted model, so that all its indices are read.
fn use_it(model: &Model) {
    let animations = (0..model.animations.len().min(4)).map(Some).chain([None]);
    for animation in animations {
        for seconds in [-1.0, 0.3, 1e9, f32::NAN] {
            let pose = model.pose(animation, seconds);
            for node in model.shown_nodes().into_iter().take(64) {
                let Some(mesh) = model.nodes[node].mesh else { continue };
                for primitive in 0..model.meshes[mesh].primitives.len().min(4) {
                    let posed = model.posed_vertices(&pose, node, primitive);
                    let vertices = model.meshes[mesh].primitives[primitive].positions.len();
                    assert_eq!((posed.positions.len(), posed.normals.len()), (vertices, vertices));
                }
            }
        }
    }
}

#[test]
fn altered_bytes_never_panic() {
    let _alone = alone();
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let file = everything().glb();
    decode(&file).unwrap();
    let json_end = 20 + u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
    let mut outcome = Outcome::within(MEMORY_LIMIT);
    for round in 0..6000 {
        let mut altered = file.clone();
        // Changes alternate between the container, the JSON and the data.
        let (start, end) = [(0, 20), (20, json_end), (json_end, file.len())][round % 3];
        for _ in 0..=random.below(3) {
            let at = start + random.below(end - start);
            altered[at] = if random.below(2) == 0 { random.next() as u8 } else { altered[at] ^ 1 << random.below(8) };
        }
        outcome.run(&|| format!("round {round}"), &altered);
    }
    outcome.print("altered bytes");
    assert!(outcome.refused > 500 && outcome.accepted > 1000);
}

#[test]
fn truncated_models_are_read_as_far_as_possible() {
    let _alone = alone();
    let file = everything().glb();
    let json_end = 20 + u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
    let mut outcome = Outcome::within(MEMORY_LIMIT);
    for end in (0..file.len()).step_by(7) {
        outcome.run(&|| format!("cut to {end}"), &file[..end]);
        assert!(decode_strictly(&file[..end]).is_err(), "cut to {end}");
        // The same with a matching header.
        let mut honest = file[..end].to_vec();
        if end > 12 {
            honest[8..12].copy_from_slice(&(end as u32).to_le_bytes());
        }
        outcome.run(&|| format!("made to end at {end}"), &honest);
        assert!(decode_strictly(&honest).is_err(), "made to end at {end}");
        if end < json_end {
            assert!(decode(&file[..end]).is_err(), "cut to {end}");
        }
        if end > 20 && end < json_end {
            outcome.run(&|| format!("JSON cut to {end}"), &glb(&file[20..end], &file[json_end + 8..]));
        }
    }
    outcome.print("truncated");
    assert!(outcome.accepted > 10 && outcome.refused > 1000);
}

fn odd_value(random: &mut Random) -> Value {
    let all = [
        json!(null),
        json!(true),
        json!(-1),
        json!(0),
        json!(1),
        json!(2),
        json!(3),
        json!(0.5),
        json!(255),
        json!(65535),
        json!(1u64 << 31),
        json!(1u64 << 32),
        json!(u64::MAX),
        json!(i64::MIN),
        json!(1e300),
        json!(-1e38),
        json!(1e-45),
        json!(5125),
        json!(5126),
        json!(""),
        json!("VEC4"),
        json!("MAT2"),
        json!("../x"),
        json!("data:,"),
        json!("CUBICSPLINE"),
        json!([]),
        json!([0]),
        json!([0, 0, 0]),
        json!({}),
        json!({ "index": 0 }),
    ];
    all[random.below(all.len())].clone()
}

fn pointers(value: &Value, here: &str, found: &mut Vec<String>) {
    found.push(here.to_owned());
    match value {
        Value::Array(all) => all.iter().enumerate().for_each(|(i, v)| pointers(v, &format!("{here}/{i}"), found)),
        Value::Object(all) => all.iter().for_each(|(key, v)| pointers(v, &format!("{here}/{key}"), found)),
        _ => {}
    }
}

fn edit(json: &mut Value, random: &mut Random) -> String {
    let mut all = Vec::new();
    pointers(json, "", &mut all);
    let pointer = all[1 + random.below(all.len() - 1)].clone();
    let (above, key) = pointer.rsplit_once('/').unwrap();
    match random.below(6) {
        0 => {
            match json.pointer_mut(above).unwrap() {
                Value::Object(object) => drop(object.remove(key)),
                Value::Array(array) => drop(array.remove(key.parse().unwrap())),
                _ => {}
            }
            format!("removed {pointer}")
        }
        1 => {
            // A value from the same model is more likely to be valid.
            let other = json.pointer(&all[random.below(all.len())]).unwrap().clone();
            *json.pointer_mut(&pointer).unwrap() = other;
            format!("replaced {pointer}")
        }
        2 => {
            if let Some(Value::Array(array)) = json.pointer_mut(above) {
                let copy = array[key.parse::<usize>().unwrap()].clone();
                array.push(copy);
            }
            format!("doubled {pointer}")
        }
        _ => {
            let odd = odd_value(random);
            let what = format!("{pointer} = {odd}");
            *json.pointer_mut(&pointer).unwrap() = odd;
            what
        }
    }
}

#[test]
fn altered_json_never_panics() {
    let _alone = alone();
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let made = everything();
    let whole = made.finished();
    let mut outcome = Outcome::within(MEMORY_LIMIT);
    for _ in 0..6000 {
        let mut json = whole.clone();
        let edits: Vec<String> = (0..=random.below(2)).map(|_| edit(&mut json, &mut random)).collect();
        outcome.run(&|| edits.join(", "), &glb(json.to_string().as_bytes(), &made.binary));
    }
    outcome.print("altered JSON");
    assert!(outcome.refused > 200 && outcome.accepted > 1000);
}

/// Changes to digits and brackets of the text may make the JSON invalid.
#[test]
fn altered_text_never_panics() {
    let _alone = alone();
    let mut random = Random(0xda94_2042_e4dd_58b5);
    let made = everything();
    let text = made.finished().to_string().into_bytes();
    let mut outcome = Outcome::within(MEMORY_LIMIT);
    for round in 0..3000 {
        let mut altered = text.clone();
        for _ in 0..=random.below(2) {
            let at = random.below(altered.len());
            match random.below(3) {
                0 => drop(altered.remove(at)),
                1 => altered[at] = b"0123456789-+eE.,:{}[]\"\\"[random.below(23)],
                _ => altered.insert(at, b"0123456789-,[]{}"[random.below(16)]),
            }
        }
        outcome.run(&|| format!("round {round}"), &glb(&altered, &made.binary));
    }
    outcome.print("altered text");
    assert!(outcome.refused > 500 && outcome.accepted > 100);
}

/// Altered bytes of complex models cause no panic.
#[test]
fn altered_creatures_never_panic() {
    let Some(folder) = shared_data("creatures") else { return };
    let _alone = alone();
    let mut random = Random(0xbf58_476d_1ce4_e5b9);
    for path in models_under(&folder).into_iter().filter(|path| path.extension().is_some_and(|e| e == "glb")) {
        let file = std::fs::read(&path).unwrap();
        let mut outcome = Outcome::within(MEMORY_LIMIT);
        for round in 0..150 {
            let mut altered = file.clone();
            let reach = if round % 2 == 0 { file.len() } else { file.len().min(60_000) };
            for _ in 0..=random.below(4) {
                let at = random.below(reach);
                altered[at] = random.next() as u8;
            }
            if round % 10 == 9 {
                altered.truncate(random.below(file.len()));
            }
            let (result, peak, time) = measured(|| decode(&altered).map(drop));
            assert!(peak < MEMORY_LIMIT && time < TIME_LIMIT, "round {round}: {peak} bytes, {time:?}");
            outcome.peak = outcome.peak.max(peak);
            outcome.slowest = outcome.slowest.max(time);
            outcome.refused += usize::from(result.is_err());
            outcome.accepted += usize::from(result.is_ok());
        }
        outcome.print(path.file_name().unwrap().to_str().unwrap());
        assert!(outcome.refused > 0);
    }
}

/// The checks must fail for a run that exceeds the limits.
#[test]
#[should_panic(expected = "bytes")]
fn runs_over_the_limit_are_detected() {
    let _alone = alone();
    let mut made = everything();
    let view = made.view(&crate::build::png(1000, 1000, &vec![7; 4_000_000]));
    made.push("images", json!({ "bufferView": view }));
    made.json["textures"][0] = json!({ "source": 2 });
    Outcome::within(3 << 20).run(&|| "a large image".into(), &made.glb());
}
