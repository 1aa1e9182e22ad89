//! The artifact reader on whole files whose tensors and header were changed: what the checksum doesn't catch.
#![no_main]

use std::collections::HashMap;
use std::sync::OnceLock;

use arbitrary::Arbitrary;
use landmarkd_fuzz::{artifacts, seeds};
use libfuzzer_sys::fuzz_target;
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde_json::Value;

#[derive(Arbitrary, Debug)]
struct Case {
    file: u8,
    edits: Vec<Edit>,
}

#[derive(Arbitrary, Debug)]
enum Edit {
    /// One number of a tensor.
    Number {
        tensor: u8,
        at: u16,
        value: Number,
    },
    /// One byte of a tensor.
    Byte {
        tensor: u8,
        at: u16,
        byte: u8,
    },
    /// A tensor cut to so many rows, or filled up to them.
    Rows {
        tensor: u8,
        rows: u16,
    },
    Lose {
        tensor: u8,
    },
    /// A member or an item of the header's JSON.
    Header {
        at: u16,
        value: Leaf,
    },
    LoseHeader {
        at: u16,
    },
    /// The same in the options, which stand in the header as text.
    Options {
        at: u16,
        value: Leaf,
    },
}

#[derive(Arbitrary, Debug)]
enum Number {
    Nan,
    Infinite,
    Huge,
    Tiny,
    Zero,
    Minus,
    Any(f32),
    Word(u32),
}

impl Number {
    fn bytes(&self) -> [u8; 4] {
        match self {
            Number::Nan => f32::NAN.to_le_bytes(),
            Number::Infinite => f32::INFINITY.to_le_bytes(),
            Number::Huge => f32::MAX.to_le_bytes(),
            Number::Tiny => f32::MIN_POSITIVE.to_le_bytes(),
            Number::Zero => 0_u32.to_le_bytes(),
            Number::Minus => (-1.0_f32).to_le_bytes(),
            Number::Any(value) => value.to_le_bytes(),
            Number::Word(value) => value.to_le_bytes(),
        }
    }
}

#[derive(Arbitrary, Debug)]
enum Leaf {
    Null,
    Flag(bool),
    Whole(i64),
    Small(i8),
    Real(f64),
    Text(String),
    List(Vec<i8>),
    Nothing,
}

impl Leaf {
    fn value(&self) -> Value {
        match self {
            Leaf::Null => Value::Null,
            Leaf::Flag(flag) => (*flag).into(),
            Leaf::Whole(number) => (*number).into(),
            Leaf::Small(number) => (*number).into(),
            Leaf::Real(number) => (*number).into(),
            Leaf::Text(text) => text.clone().into(),
            Leaf::List(items) => items.clone().into(),
            Leaf::Nothing => Value::Object(Default::default()),
        }
    }
}

type Tensor = (String, Dtype, Vec<usize>, Vec<u8>);

struct Parts {
    tensors: Vec<Tensor>,
    header: Value,
}

fn trained() -> &'static [Vec<u8>] {
    static TRAINED: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    TRAINED.get_or_init(artifacts::trained)
}

fn taken_apart(file: &[u8]) -> Parts {
    let (_, metadata) = SafeTensors::read_metadata(file).expect("a trained file is whole");
    let text = &metadata.metadata().as_ref().expect("it has metadata")["landmarkd"];
    let tensors = SafeTensors::deserialize(file).expect("a trained file is whole");
    let mut tensors: Vec<Tensor> = (tensors.tensors().into_iter())
        .map(|(name, view)| (name, view.dtype(), view.shape().to_vec(), view.data().to_vec()))
        .collect();
    tensors.sort_by(|a, b| a.0.cmp(&b.0));
    Parts { tensors, header: serde_json::from_str(text).expect("it is JSON") }
}

/// The pointers of everything in a value.
fn pointers(value: &Value, at: String, all: &mut Vec<String>) {
    match value {
        Value::Object(members) => {
            for (name, member) in members {
                pointers(member, format!("{at}/{name}"), all);
            }
        }
        Value::Array(items) => {
            for (number, item) in items.iter().enumerate() {
                pointers(item, format!("{at}/{number}"), all);
            }
        }
        _ => {}
    }
    all.push(at);
}

fn chosen(value: &Value, at: u16) -> String {
    let mut all = Vec::new();
    pointers(value, String::new(), &mut all);
    all.swap_remove(usize::from(at) % all.len())
}

fn put(value: &mut Value, at: u16, leaf: Value) {
    let pointer = chosen(value, at);
    *value.pointer_mut(&pointer).expect("it was just found") = leaf;
}

fn lose(value: &mut Value, at: u16) {
    let pointer = chosen(value, at);
    let Some((parent, name)) = pointer.rsplit_once('/') else { return };
    match value.pointer_mut(parent) {
        Some(Value::Object(members)) => drop(members.remove(name)),
        Some(Value::Array(items)) => drop(items.remove(name.parse().expect("an item has a number"))),
        _ => {}
    }
}

fn change(parts: &mut Parts, edit: &Edit) {
    let count = parts.tensors.len();
    let which = |tensor: u8| usize::from(tensor) % count.max(1);
    match edit {
        _ if count == 0 => {}
        Edit::Number { tensor, at, value } => {
            let bytes = &mut parts.tensors[which(*tensor)].3;
            let words = bytes.len() / 4;
            if words > 0 {
                let at = 4 * (usize::from(*at) % words);
                bytes[at..at + 4].copy_from_slice(&value.bytes());
            }
        }
        Edit::Byte { tensor, at, byte } => {
            let bytes = &mut parts.tensors[which(*tensor)].3;
            if !bytes.is_empty() {
                let at = usize::from(*at) % bytes.len();
                bytes[at] = *byte;
            }
        }
        Edit::Rows { tensor, rows } => {
            let (_, _, shape, bytes) = &mut parts.tensors[which(*tensor)];
            if let Some(first) = shape.first_mut().filter(|first| **first > 0) {
                let row_bytes = bytes.len() / *first;
                *first = usize::from(*rows) % 512;
                bytes.resize(*first * row_bytes, 0);
            }
        }
        Edit::Lose { tensor } => drop(parts.tensors.remove(which(*tensor))),
        Edit::Header { at, value } => put(&mut parts.header, *at, value.value()),
        Edit::LoseHeader { at } => lose(&mut parts.header, *at),
        Edit::Options { at, value } => {
            let Some(text) = parts.header["options"].as_str() else { return };
            let Ok(mut options) = serde_json::from_str::<Value>(text) else { return };
            put(&mut options, *at, value.value());
            parts.header["options"] = options.to_string().into();
        }
    }
}

fuzz_target!(init: { seeds::write(seeds::noise); trained(); }, |case: Case| {
    let mut parts = taken_apart(&trained()[usize::from(case.file) % trained().len()]);
    for edit in &case.edits {
        if !parts.header.is_object() {
            return;
        }
        change(&mut parts, edit);
    }
    if !parts.header.is_object() {
        return;
    }
    let views = parts.tensors.iter().filter_map(|(name, dtype, shape, bytes)| {
        Some((name, TensorView::new(*dtype, shape.clone(), bytes).ok()?))
    });
    let metadata = HashMap::from([("landmarkd".to_owned(), parts.header.to_string())]);
    let Ok(file) = safetensors::serialize(views, Some(metadata)) else { return };
    if let Some(with_checksum) = artifacts::with_checksum(&file) {
        artifacts::read(&with_checksum);
    }
});
