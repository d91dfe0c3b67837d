// MipfoldMips.cs puts the mip levels of mipfold into textures while Unity
// imports them, before it compresses them.
//
// Written after the manual of Unity 6; it was not run in the engine.
//
// Copy it to Assets/Editor/MipfoldMips.cs, once for a project. It then works
// on each import of a PNG that a manifest.json of mipfold beside it names.
#if UNITY_EDITOR
using System;
using System.IO;
using UnityEditor;
using UnityEngine;

class MipfoldMips : AssetPostprocessor
{
    // What is read of manifest.json.
    [Serializable]
    class Manifest
    {
        public string generator = "";
        public Map[] maps = new Map[0];
    }

    [Serializable]
    class Map
    {
        public string role = "";
        public string[] files = new string[0];
    }

    public override uint GetVersion() => 1;

    void OnPreprocessTexture()
    {
        var map = Find(out int level);
        if (map == null) return;
        var importer = (TextureImporter)assetImporter;
        importer.sRGBTexture = false;
        importer.npotScale = TextureImporterNPOTScale.None;
        if (level > 0)
        {
            // Only this script reads it, and reads the file itself.
            importer.mipmapEnabled = false;
            importer.maxTextureSize = 32;
            return;
        }
        importer.mipmapEnabled = true;
        // The rest is a proposal: what was clicked later stays.
        if (!importer.importSettingsMissing) return;
        if (map.role == "normal") importer.textureType = TextureImporterType.NormalMap;
        importer.textureCompression = TextureImporterCompression.CompressedHQ;
        importer.maxTextureSize = 8192;
    }

    void OnPostprocessTexture(Texture2D texture)
    {
        var map = Find(out int level);
        if (map == null || level > 0) return;
        var file = new Texture2D(2, 2, TextureFormat.RGBA32, false, true);
        bool inAlpha = false;
        int next = 0;
        for (int mip = 0; mip < texture.mipmapCount; mip++)
        {
            int width = Math.Max(1, texture.width >> mip);
            int height = Math.Max(1, texture.height >> mip);
            // Under a smaller Max Size the first levels are left out.
            Color[] texels = null;
            for (; texels == null && next < map.files.Length; next++)
            {
                string path = Beside(map.files[next]);
                context.DependsOnSourceAsset(path);
                if (!File.Exists(path) || !file.LoadImage(File.ReadAllBytes(path))) break;
                if (file.width == width && file.height == height) texels = file.GetPixels();
            }
            if (texels == null)
            {
                Debug.LogError($"{assetPath}: no level of {width}x{height} texels; its mips are Unity's own.");
                break;
            }
            if (map.role == "normal")
            {
                // Unity may have moved x into alpha by now: its level 0 tells.
                if (mip == 0) inAlpha = RedIsInAlpha(texture.GetPixels(0), texels);
                if (inAlpha)
                    for (int i = 0; i < texels.Length; i++)
                        texels[i] = new Color(1, texels[i].g, 1, texels[i].r);
            }
            texture.SetPixels(texels, mip);
        }
        UnityEngine.Object.DestroyImmediate(file);
    }

    // The map of which the texture is a level, or null.
    Map Find(out int level)
    {
        level = -1;
        string path = Beside("manifest.json");
        if (!assetPath.EndsWith(".png", StringComparison.OrdinalIgnoreCase) || !File.Exists(path)) return null;
        var manifest = JsonUtility.FromJson<Manifest>(File.ReadAllText(path));
        if (manifest == null || manifest.generator != "mipfold") return null;
        foreach (var map in manifest.maps)
        {
            level = Array.IndexOf(map.files, Path.GetFileName(assetPath));
            if (level >= 0) return map;
        }
        return null;
    }

    string Beside(string name) => Path.GetDirectoryName(assetPath).Replace('\\', '/') + "/" + name;

    static bool RedIsInAlpha(Color[] imported, Color[] stored)
    {
        float red = 0, alpha = 0;
        for (int i = 0; i < stored.Length; i++)
        {
            red += Math.Abs(imported[i].r - stored[i].r);
            alpha += Math.Abs(imported[i].a - stored[i].r);
        }
        return alpha < red;
    }
}
#endif
