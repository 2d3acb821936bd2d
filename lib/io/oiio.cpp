// The module pave-oiio.so: image files in memory to pixels and back, through OpenImageIO.
#include "io/codec.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <vector>

using OIIO::ImageInput;
using OIIO::ImageOutput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

namespace {

// What a decoder reads comes from the host, from any place of the file.
class Source final : public OIIO::Filesystem::IOProxy {
public:
    explicit Source(const pv_codec_file &file) : IOProxy("", Read), file(file) {}
    const char *proxytype() const override { return "pave"; }

    size_t read(void *bytes, size_t size) override
    {
        size_t done = pread(bytes, size, m_pos);
        m_pos += int64_t(done);
        return done;
    }

    size_t pread(void *bytes, size_t size, int64_t offset) override
    {
        size_t left = offset >= 0 && size_t(offset) < file.size ? file.size - size_t(offset) : 0;
        size_t wanted = std::min(size, left);
        return wanted && file.read(file.user, offset, bytes, wanted) ? wanted : 0;
    }

    size_t size() const override { return file.size; }

private:
    pv_codec_file file;
};

// What an encoder writes goes straight to the host, at any place of the file.
class Sink final : public OIIO::Filesystem::IOProxy {
public:
    Sink(pv_codec_sink function, void *user) : IOProxy("", Write), function(function), user(user) {}
    const char *proxytype() const override { return "pave"; }

    size_t write(const void *bytes, size_t size) override
    {
        size_t done = pwrite(bytes, size, m_pos);
        m_pos += int64_t(done);
        return done;
    }

    size_t pwrite(const void *bytes, size_t size, int64_t offset) override
    {
        if (!function(user, offset, bytes, size))
            return 0;
        end = std::max(end, offset + int64_t(size));
        return size;
    }

    size_t size() const override { return size_t(end); }

private:
    pv_codec_sink function;
    void *user;
    int64_t end = 0;
};

} // namespace

struct pv_codec_job {
    std::unique_ptr<OIIO::Filesystem::IOProxy> file; // outlives what uses it
    std::unique_ptr<ImageInput> input;
    std::unique_ptr<ImageOutput> output;
    ImageSpec spec;
    TypeDesc type;
};

namespace {

// OpenImageIO's errors have several lines, and name files that do not exist.
void tell(char *text, const std::string &reason)
{
    std::string line = reason.substr(0, reason.find('\n'));
    line = line.substr(0, line.find(" (\""));
    std::snprintf(text, PV_CODEC_TEXT, "%s", line.empty() ? "no reason given" : line.c_str());
}

template<class Body> pave_result guarded(char *text, Body body) noexcept
{
    *text = 0;
    try {
        return body();
    } catch (const std::bad_alloc &) {
        std::snprintf(text, PV_CODEC_TEXT, "out of memory");
        return PAVE_ERR_MEMORY;
    } catch (const std::exception &e) {
        std::snprintf(text, PV_CODEC_TEXT, "%s", e.what());
    } catch (...) {
        std::snprintf(text, PV_CODEC_TEXT, "an exception of an unknown kind");
    }
    return PAVE_ERR_INTERNAL;
}

int32_t pave_type(TypeDesc type)
{
    switch (type.basetype) {
    case TypeDesc::UINT8: return PAVE_U8;
    case TypeDesc::UINT16: return PAVE_U16;
    case TypeDesc::UINT32: return PAVE_U32;
    case TypeDesc::HALF: return PAVE_F16;
    default: return PAVE_F32;
    }
}

TypeDesc oiio_type(int32_t type)
{
    switch (type) {
    case PAVE_U8: return TypeDesc::UINT8;
    case PAVE_U16: return TypeDesc::UINT16;
    case PAVE_U32: return TypeDesc::UINT32;
    case PAVE_F16: return TypeDesc::HALF;
    default: return TypeDesc::FLOAT;
    }
}

void describe(const ImageSpec &spec, pv_picture *picture)
{
    picture->width = spec.width;
    picture->height = spec.height;
    picture->channels = spec.nchannels;
    picture->type = pave_type(spec.format);
    picture->linear = spec.format.is_floating_point();
    picture->alpha = spec.alpha_channel;
    picture->columns = spec.tile_width ? spec.tile_width : spec.width;
    picture->rows = spec.tile_width ? spec.tile_height : 1;
    std::string names;
    for (const std::string &name : spec.channelnames)
        names += (names.empty() ? "" : ",") + name;
    std::snprintf(picture->names, sizeof picture->names, "%s", names.c_str());
}

pave_result decode(pave_context *, const char *format, const pv_codec_file *file, pv_picture *picture,
                   pv_codec_job **out, char *text) noexcept
{
    *out = nullptr;
    return guarded(text, [&] {
        auto job = std::make_unique<pv_codec_job>();
        if (file->bytes)
            job->file = std::make_unique<OIIO::Filesystem::IOMemReader>(file->bytes, file->size);
        else
            job->file = std::make_unique<Source>(*file);
        job->input = ImageInput::create(format);
        if (!job->input)
            return tell(text, OIIO::geterror()), PAVE_ERR_UNSUPPORTED;
        ImageSpec config;
        config.attribute("oiio:UnassociatedAlpha", 1);
        job->input->set_ioproxy(job->file.get());
        if (!job->input->open(std::string("memory.") + format, job->spec, config))
            return tell(text, job->input->geterror()), PAVE_ERR_FORMAT;
        if (job->spec.depth > 1)
            return tell(text, "it is a volume"), PAVE_ERR_UNSUPPORTED;
        describe(job->spec, picture);
        job->type = oiio_type(picture->type);
        *out = job.release();
        return PAVE_OK;
    });
}

// libjpeg goes on after damage, with a warning; a few are harmless.
bool harmful(const std::string &warning)
{
    return !warning.empty() && warning.find("extraneous bytes") == std::string::npos &&
           warning.find("Unknown Adobe") == std::string::npos && warning.find("Invalid SOS") == std::string::npos;
}

pave_result read(pv_codec_job *job, int32_t x, int32_t y, int32_t width, int32_t height, void *pixels,
                 char *text) noexcept
{
    return guarded(text, [&] {
        const ImageSpec &spec = job->spec;
        int x0 = spec.x + x, y0 = spec.y + y;
        bool good = spec.tile_width ? job->input->read_tiles(0, 0, x0, x0 + width, y0, y0 + height, spec.z, spec.z + 1,
                                                             0, spec.nchannels, job->type, pixels)
                                    : job->input->read_scanlines(0, 0, y0, y0 + height, spec.z, 0, spec.nchannels,
                                                                 job->type, pixels);
        std::string reason = job->input->geterror();
        if (good && !harmful(reason))
            return PAVE_OK;
        return tell(text, reason), PAVE_ERR_FORMAT;
    });
}

ImageSpec spec_of(const char *format, const pv_picture &picture)
{
    ImageSpec spec(picture.width, picture.height, picture.channels, oiio_type(picture.type));
    spec.alpha_channel = picture.alpha;
    spec.attribute("oiio:UnassociatedAlpha", 1);
    spec.attribute("oiio:ColorSpace", picture.linear ? "Linear" : "sRGB");
    if (!std::strcmp(format, "tiff")) {
        spec.attribute("Compression", "zip");
        spec.attribute("tiff:write_exif", 0);
    }
    return spec;
}

pave_result encode(pave_context *, const char *format, const pv_picture *picture, pv_codec_sink function, void *user,
                   pv_codec_job **out, char *text) noexcept
{
    *out = nullptr;
    return guarded(text, [&] {
        auto job = std::make_unique<pv_codec_job>();
        job->file = std::make_unique<Sink>(function, user);
        job->output = ImageOutput::create(format);
        if (!job->output)
            return tell(text, OIIO::geterror()), PAVE_ERR_UNSUPPORTED;
        job->spec = spec_of(format, *picture);
        job->type = oiio_type(picture->type);
        job->output->set_ioproxy(job->file.get());
        if (!job->output->open(std::string("memory.") + format, job->spec))
            return tell(text, job->output->geterror()), PAVE_ERR_UNSUPPORTED;
        *out = job.release();
        return PAVE_OK;
    });
}

pave_result write(pv_codec_job *job, int32_t from, int32_t to, const void *pixels, char *text) noexcept
{
    return guarded(text, [&] {
        if (job->output->write_scanlines(from, to, 0, job->type, pixels))
            return PAVE_OK;
        return tell(text, job->output->geterror()), PAVE_ERR_IO;
    });
}

pave_result finish(pv_codec_job *job, char *text) noexcept
{
    return guarded(text, [&] {
        if (job->output->close())
            return PAVE_OK;
        return tell(text, job->output->geterror()), PAVE_ERR_IO;
    });
}

void close(pv_codec_job *job) noexcept
{
    char text[PV_CODEC_TEXT];
    std::unique_ptr<pv_codec_job> closed(job);
    guarded(text, [&] {
        closed.reset();
        return PAVE_OK;
    });
}

const pv_codec codec = { decode, read, encode, write, finish, close };

} // namespace

extern "C" __attribute__((visibility("default"))) const pv_codec *pave_oiio_codec(int32_t version) noexcept
{
    return version == PV_CODEC_VERSION ? &codec : nullptr;
}
