//! Links the parts missing from Debian's libshaderc: its archive lacks glslang and SPIRV-Tools, and its shared object lacks
//! some of their symbols. A program that links the `shaderc` crate must also link this one, which has no code of its own. On
//! other systems, or if `SHADERC_LIB_DIR` or `VULKAN_SDK` selects another shaderc, it links nothing.
