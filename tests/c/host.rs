//! host SCENE: a host in Rust, through the C interface: renders a scene of a file, edits it, renders it again,
//! and gets errors as values. Exits with 1 and a line if something is not so.
use std::ffi::{c_char, c_void, CStr, CString};
use std::ptr::{null, null_mut};

/// The part of raygraph.h that is used here.
mod ffi {
    use super::*;

    macro_rules! handles {
        ($($name:ident),*) => { $(#[repr(C)] pub struct $name { _opaque: [u8; 0] })* };
    }
    handles!(RgDevice, RgScene, RgSettings, RgPicture);

    pub const RG_OK: i32 = 0;
    pub const RG_ERROR_USAGE: i32 = 1;
    pub const RG_ERROR_BAD_INPUT: i32 = 2;
    pub const RG_NODE: u32 = 0;

    #[repr(C)]
    pub struct RgProgress {
        pub struct_size: u32,
        pub samples: u32,
        pub samples_wanted: u32,
        pub reserved: u32,
        pub samples_per_second: f64,
        pub relative_error: f64,
        pub seconds_left: f64,
    }
    #[repr(C)]
    pub struct RgChannel {
        pub struct_size: u32,
        pub number: u32,
        pub width: u32,
        pub height: u32,
        pub channels: u32,
        pub pixel_stride: u32,
        pub data: *const c_void,
    }
    pub type RgProgressCallback = Option<extern "C" fn(*mut c_void, *const RgProgress) -> bool>;

    #[link(name = "raygraph")]
    extern "C" {
        pub fn rg_last_error() -> *const c_char;
        pub fn rg_device_create(desc: *const c_void, device: *mut *mut RgDevice) -> i32;
        pub fn rg_device_destroy(device: *mut RgDevice);
        pub fn rg_scene_load(path: *const c_char, desc: *const c_void, scene: *mut *mut RgScene) -> i32;
        pub fn rg_scene_destroy(scene: *mut RgScene);
        pub fn rg_scene_count(scene: *const RgScene, kind: u32, count: *mut u32) -> i32;
        pub fn rg_scene_set(scene: *mut RgScene, kind: u32, index: u32, name: *const c_char, values: *const f32,
                            count: u32) -> i32;
        pub fn rg_settings_create(settings: *mut *mut RgSettings) -> i32;
        pub fn rg_settings_destroy(settings: *mut RgSettings);
        pub fn rg_settings_set(settings: *mut RgSettings, name: *const c_char, text: *const c_char) -> i32;
        pub fn rg_render(device: *mut RgDevice, scene: *mut RgScene, settings: *const RgSettings,
                         progress: RgProgressCallback, user: *mut c_void, picture: *mut *mut RgPicture) -> i32;
        pub fn rg_picture_get_channel(picture: *const RgPicture, name: *const c_char, channel: *mut RgChannel) -> i32;
        pub fn rg_picture_destroy(picture: *mut RgPicture);
    }
}
use ffi::*;

#[derive(Debug)]
struct Error {
    result: i32,
    line: String,
}
impl std::fmt::Display for Error {
    fn fmt(&self, to: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(to, "{} ({})", self.line, self.result)
    }
}

fn last_error() -> String {
    unsafe { CStr::from_ptr(rg_last_error()) }.to_string_lossy().into_owned()
}
fn check(result: i32) -> Result<(), Error> {
    if result == RG_OK { Ok(()) } else { Err(Error { result, line: last_error() }) }
}
fn text(text: &str) -> CString {
    CString::new(text).expect("a text without zeros")
}

struct Device(*mut RgDevice);
impl Device {
    fn open() -> Result<Device, Error> {
        let mut device = null_mut();
        check(unsafe { rg_device_create(null(), &mut device) })?;
        Ok(Device(device))
    }
}
impl Drop for Device {
    fn drop(&mut self) {
        unsafe { rg_device_destroy(self.0) }
    }
}

struct Scene(*mut RgScene);
impl Scene {
    fn load(path: &str) -> Result<Scene, Error> {
        let mut scene = null_mut();
        check(unsafe { rg_scene_load(text(path).as_ptr(), null(), &mut scene) })?;
        Ok(Scene(scene))
    }
    fn node_count(&self) -> Result<u32, Error> {
        let mut count = 0;
        check(unsafe { rg_scene_count(self.0, RG_NODE, &mut count) })?;
        Ok(count)
    }
    fn set(&mut self, kind: u32, index: u32, name: &str, values: &[f32]) -> Result<(), Error> {
        check(unsafe { rg_scene_set(self.0, kind, index, text(name).as_ptr(), values.as_ptr(), values.len() as u32) })
    }
}
impl Drop for Scene {
    fn drop(&mut self) {
        unsafe { rg_scene_destroy(self.0) }
    }
}

struct Settings(*mut RgSettings);
impl Settings {
    fn new(options: &[(&str, &str)]) -> Result<Settings, Error> {
        let mut settings = null_mut();
        check(unsafe { rg_settings_create(&mut settings) })?;
        let settings = Settings(settings);
        for (name, value) in options {
            check(unsafe { rg_settings_set(settings.0, text(name).as_ptr(), text(value).as_ptr()) })?;
        }
        Ok(settings)
    }
}
impl Drop for Settings {
    fn drop(&mut self) {
        unsafe { rg_settings_destroy(self.0) }
    }
}

/// Counts the calls in the u32 that `user` points at.
extern "C" fn count(user: *mut c_void, progress: *const RgProgress) -> bool {
    unsafe {
        *(user as *mut u32) += 1;
        (*progress).samples <= (*progress).samples_wanted
    }
}

/// Returns RGBA of each pixel, and how often there was progress.
fn render(device: &Device, scene: &mut Scene, settings: &Settings) -> Result<(Vec<f32>, u32), Error> {
    let (mut picture, mut calls) = (null_mut(), 0u32);
    let user = &mut calls as *mut u32 as *mut c_void;
    check(unsafe { rg_render(device.0, scene.0, settings.0, Some(count), user, &mut picture) })?;
    let mut channel = RgChannel {
        struct_size: std::mem::size_of::<RgChannel>() as u32,
        number: 0, width: 0, height: 0, channels: 0, pixel_stride: 0, data: null(),
    };
    let got = check(unsafe { rg_picture_get_channel(picture, text("color").as_ptr(), &mut channel) });
    let size = (channel.width * channel.height * channel.channels) as usize;
    let color = match got {
        Ok(()) => Ok(unsafe { std::slice::from_raw_parts(channel.data as *const f32, size) }.to_vec()),
        Err(error) => Err(error),
    };
    unsafe { rg_picture_destroy(picture) };
    Ok((color?, calls))
}

fn require(holds: bool, what: &str) -> Result<(), Error> {
    if holds { Ok(()) } else { Err(Error { result: RG_OK, line: format!("not so: {what}") }) }
}

fn run(path: &str) -> Result<(), Error> {
    let device = Device::open()?;
    let mut scene = Scene::load(path)?;
    let settings = Settings::new(&[("size", "16x12"), ("spp", "4"), ("background", "0,0,0")])?;
    let (lit, calls) = render(&device, &mut scene, &settings)?;
    require(lit.len() == 16 * 12 * 4 && calls >= 4, "a picture of this size, with progress for each sample")?;
    require(lit.iter().all(|value| value.is_finite()) && lit.iter().any(|&value| value > 0.1), "there is light")?;

    for node in 0..scene.node_count()? {
        scene.set(RG_NODE, node, "visible", &[0.0])?;
    }
    let (empty, _) = render(&device, &mut scene, &settings)?;
    require(empty.iter().all(|&value| value == 0.0), "nothing is seen of hidden nodes")?;

    let Err(wrong) = scene.set(RG_NODE, 0, "visible", &[0.0, 1.0]) else {
        return require(false, "a wrong count is refused");
    };
    require(wrong.result == RG_ERROR_USAGE && wrong.line.contains("visible has 1 number, and 2 are given"), &wrong.line)?;
    // The last error is of its thread
    let other = std::thread::spawn(|| (last_error(), Scene::load("none such.gltf").err().map(|error| error.result)));
    require(other.join().ok() == Some((String::new(), Some(RG_ERROR_BAD_INPUT))), "each thread has its own error")?;
    require(last_error() == wrong.line, "the error of another thread is not seen here")
}

fn main() {
    let path = std::env::args().nth(1).unwrap_or_else(|| {
        eprintln!("host SCENE");
        std::process::exit(2);
    });
    if let Err(error) = run(&path) {
        eprintln!("{error}");
        std::process::exit(1);
    }
    println!("rendered and edited from Rust");
}
