//! Links what Debian's libshaderc leaves out: its archive lacks glslang and SPIRV-Tools, and its shared object misses symbols of
//! them. A program that links the `shaderc` crate links with this one as well; it has no code of its own. Elsewhere, or where
//! `SHADERC_LIB_DIR` or `VULKAN_SDK` names another shaderc, it links nothing.
